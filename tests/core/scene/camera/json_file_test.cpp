// Mistakes in JSON files are named with their place.
#include "core/foundation/config/json_file.h"

#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/scene/camera/transforms_file.h"
#include "core/foundation/config/yaml.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

class JsonFile : public testing::Test {
 protected:
  Error refusal(const std::string& text) {
    write_file(path(), text);
    return error_of([&] { read_json_file(path(), "test file", [](const nlohmann::json&) {}); });
  }
  fs::path path() const { return folder.path() / "t.json"; }
  TemporaryFolder folder;
};

TEST_F(JsonFile, NamesTheMistakesThatPeopleAndProgramsMake) {
  struct {
    const char *text, *place, *why;
  } mistakes[] = {{"{\n \"a\": 1,\n}", "2:8", "the comma before '}'"},
                  {"[1, 2,]", "1:6", "the comma before ']'"},
                  {"{\n// note\n\"a\": 1}", "2:1", "a comment"},
                  {"[1, # two\n2]", "1:5", "a comment"},
                  {"{\"a\": NaN}", "1:7", "'NaN' is no number"},
                  {"[1,\n -Infinity]", "2:2", "'-Infinity' is no number"},
                  {"[None]", "1:2", "write null"},
                  {"[True]", "1:2", "write true"},
                  {"{'a': 1}", "1:2", "double quotes"},
                  {"{\"a\": \"C:\\Users\"}", "1:11", "backslash"},
                  {"{\"a\": 1 \"b\": 2}", "1:9", "a comma is missing"},
                  {"[1 2]", "1:4", "a comma is missing"},
                  {"[{} {}]", "1:5", "a comma is missing"},
                  {"{\"a\" \"b\"}", "1:6", "a colon is missing"},
                  {"{\"a\": [1, 2", "1:12", "ends in the middle"},
                  {"[1] x", "1:5", "not expected"},
                  {" \n", "", "empty"},
                  {"", "", "empty"}};
  for (const auto& m : mistakes) {
    const Error e = refusal(m.text);
    EXPECT_EQ(e.detail().code, "BAD_JSON") << m.text;
    EXPECT_NE(e.detail().why.find(m.why), std::string::npos) << m.text << "\n" << e.what();
    EXPECT_NE(e.detail().where.find("t.json:" + std::string(m.place)), std::string::npos) << m.text << "\n" << e.what();
    EXPECT_EQ(std::string(e.what()).find("json.exception"), std::string::npos) << e.what();
  }
  EXPECT_EQ(std::string(refusal("[\"\xff\"]").what()).find("json.exception"), std::string::npos);
  EXPECT_EQ(std::string(refusal("[1e999]").what()).find("json.exception"), std::string::npos);
}

TEST_F(JsonFile, MayBeginWithAByteOrderMark) {
  write_file(path(), "\xef\xbb\xbf{\"a\": 1}");
  double a = 0;
  read_json_file(path(), "test file", [&](const nlohmann::json& j) { a = JsonAt(j).at("a").number(); });
  EXPECT_EQ(a, 1);
  EXPECT_EQ(refusal(std::string("\xff\xfe{\0}\0", 6)).detail().code, "TEXT_ENCODING");
  EXPECT_EQ(refusal(std::string("{\0}\0", 4)).detail().code, "TEXT_ENCODING");
  write_file(folder.path() / "t.yaml", "\xef\xbb\xbfsize: 3\n");
  EXPECT_NE(read_yaml((folder.path() / "t.yaml").string()).root.find("size"), nullptr);
}

TEST_F(JsonFile, WrongTypesAreNamedWithPathLineAndColumn) {
  const auto transforms = [&](const std::string& text) {
    write_file(path(), text);
    return error_of([&] { read_transforms_file(path()); }).detail();
  };
  const ErrorDetail matrix = transforms("{\"fl_x\": 1, \"frames\": [\n {\"file_path\": \"a\", \"transform_matrix\": [[1]]}]}");
  EXPECT_NE(matrix.why.find("frames[0].transform_matrix: expected a 4x4 matrix"), std::string::npos) << matrix.why;
  EXPECT_NE(matrix.where.find("t.json:2:41"), std::string::npos) << matrix.where;
  const ErrorDetail name = transforms("{\"fl_x\": 1, \"frames\": [{\"file_path\": 3}]}");
  EXPECT_NE(name.why.find("frames[0].file_path: expected a text, found a number"), std::string::npos) << name.why;
  const ErrorDetail missing = transforms("{\"fl_x\": 1, \"frames\": [{\"file_path\": \"a\"}]}");
  EXPECT_NE(missing.why.find("frames[0]: 'transform_matrix' is missing"), std::string::npos) << missing.why;
  EXPECT_NE(transforms("{\"frames\": 3}").why.find("frames: expected a list of frames, found a number"), std::string::npos);
  EXPECT_NE(transforms("3").why.find("neither an object"), std::string::npos);
  EXPECT_NE(transforms("{\"camera_path\": []}").why.find("camera path of nerfstudio's viewer"), std::string::npos);
}

TEST(JsonText, FindsTheValueOfAPointer) {
  const std::string text = R"({ "a": [1, {"b\"c": 2, "d" : "x,]}"}, [ ] ], "e": {} })";
  const auto at = [&](const char* pointer) { return text.substr(*place_of_value(text, pointer), 3); };
  EXPECT_EQ(at("/a/0"), "1, ");
  EXPECT_EQ(at("/a/1/d"), "\"x,");
  EXPECT_EQ(at("/a/2"), "[ ]");
  EXPECT_EQ(at("/e"), "{} ");
  EXPECT_EQ(at("/a/7"), "[1,") << "what is not there: the deepest that is";
  EXPECT_EQ(at(""), "{ \"");
}

}  // namespace
}  // namespace vitrine
