// report.html in headless Chromium, from file://: nothing said on the console, nothing asked of the network, readable on a phone.
#include <gtest/gtest.h>

#include "tests/pages/in_chromium.h"
#include "tests/pipeline/report_page/small_output.h"

namespace vitrine {
namespace {

using nlohmann::json;

using ReportPage = InChromium;

TEST_F(ReportPage, OpensOnDeskAndPhoneWithoutAWordOrARequest) {
  const TemporaryFolder folder;
  test::write_output(folder.path(), {.photo = "<script>alert(1)<img src=x onerror=alert(2)>.jpg", .psnr = 20, .registered = 2});
  write_file(folder.path() / "view.html", "<html></html>");
  const fs::path file = folder.path() / "report.html";
  write_file(file, test::page(folder.path()));
  const fs::path out = pictures("report");
  for (const auto& [width, scheme] : {std::pair("1280", "light"), std::pair("390", "dark")}) {
    SCOPED_TRACE(width);
    const std::string picture = (out / fmt::format("{}_{}.png", width, scheme)).string();
    const json r = answer(run_script({"open_page.mjs", file.string(), picture, width, scheme}));
    ASSERT_FALSE(r.empty());
    EXPECT_TRUE(r["messages"].empty()) << r["messages"];
    EXPECT_LE(r["scroll"], std::stoi(width));
    EXPECT_GT(r["readable"], 0.95) << r;  // asked for: 0.8
    EXPECT_GT(r["pictures"][0], 8);
    EXPECT_EQ(r["pictures"][1], 0);
    EXPECT_EQ(r["blank"], 0);
    EXPECT_EQ(r["opening"], "view.html");
    EXPECT_GE(r["printed"][0], 2);
    EXPECT_GE(r["printed"][1], 8) << "pictures on paper: all of different contents";
    EXPECT_EQ(r["split"], "80%");
    EXPECT_EQ(r["colour"], std::string(scheme) == "dark" ? "rgb(22, 22, 20)" : "rgb(251, 250, 247)");
  }
}

}  // namespace
}  // namespace vitrine
