// XML files of other programs: errors name file, line and column. For *.cpp files only (keeps pugixml out of public headers).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <pugixml.hpp>

namespace vitrine {

class XmlFile {
 public:
  // `format`: what the file should be, `hint`: what to do about a mistake; both are used in errors. Throws Error{Input}: no XML.
  XmlFile(const std::filesystem::path& path, const char* format, const char* hint);

  pugi::xml_node root() const { return document_.document_element(); }
  // Throws Error{Input} with the place of the element; of the file for an empty one.
  [[noreturn]] void fail(pugi::xml_node at, const std::string& why) const;

  // Child element; throws if it is missing.
  pugi::xml_node child(pugi::xml_node parent, const char* name) const;
  // The text of an element, or of one of its attributes: exactly `count` finite numbers, separated by spaces.
  std::vector<double> numbers(pugi::xml_node element, size_t count) const;
  double number(pugi::xml_node element) const { return numbers(element, 1)[0]; }
  double number_of_child(pugi::xml_node parent, const char* name, double otherwise) const;
  double attribute(pugi::xml_node element, const char* name) const;

 private:
  std::vector<double> parsed(pugi::xml_node at, const std::string& what, const char* text, size_t count) const;
  [[noreturn]] void fail_at(std::ptrdiff_t byte, const std::string& why) const;

  std::filesystem::path path_;
  const char *format_, *hint_;
  std::string text_;
  pugi::xml_document document_;
};

}  // namespace vitrine
