// Every name of the version before that a table of options accepts, written as a user would.
#pragma once

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/config/apply.h"

namespace vitrine::test {

// A value that the option takes and that is not its default.
inline std::string other_value(const Option& o) {
  const std::string type = o.type();
  if (type == "bool") return o.default_text == "true" ? "false" : "true";
  if (!o.choices.empty()) return o.choices.front() == o.default_text ? o.choices.back() : o.choices.front();
  if (type == "string" || type == "string list") return "other";
  const double low = o.low.value_or(0);
  return o.default_text == fmt::format("{}", low) ? fmt::format("{}", o.high.value_or(low + 1)) : fmt::format("{}", low);
}

struct Written {
  std::string path, value;
};

// `path: value` as nested maps.
inline std::string nested(const Written& w) {
  std::string text, indent;
  size_t from = 0;
  for (size_t dot; (dot = w.path.find('.', from)) != std::string::npos; from = dot + 1, indent += "  ")
    text += indent + w.path.substr(from, dot - from) + ":\n";
  return text + indent + w.path.substr(from) + ": " + w.value + "\n";
}

struct Parsed {
  std::string values, complaint;
  std::vector<std::string> warnings;
};

// `table` is a fresh one, over values at their defaults.
template <class Apply>
Parsed parsed(OptionTable& table, Apply apply) {
  ConfigErrors errors;
  apply(table, errors);
  Parsed out{.values = table.canonical_text(), .complaint = {}, .warnings = errors.warnings()};
  try {
    errors.throw_if_any("");
  } catch (const Error& e) {
    out.complaint = e.message();
  }
  return out;
}

inline auto from_yaml(const std::string& text) {
  return [text](OptionTable& table, ConfigErrors& errors) {
    const YamlFile file = parse_yaml(text, "old.yaml");
    apply_yaml(file, file.root, table, {}, errors);
  };
}

inline auto from_sets(const std::vector<Written>& all) {
  return [all](OptionTable& table, ConfigErrors& errors) {
    for (const Written& w : all) apply_set(w.path + "=" + w.value, table, "--set", errors);
  };
}

// Every old name means the same as the new one, in a file and on the command line, with one warning that has both; an old and the
// new name beside each other are an error. `fresh(check)` calls check(table) with a table of its own.
template <class Fresh>
void expect_old_names_are_accepted(Fresh fresh) {
  std::vector<Renaming> renamed;
  std::vector<Option> options;
  fresh([&](OptionTable& table) { renamed = table.renamed, options = table.options; });
  const auto with = [&](auto apply) {
    Parsed p;
    fresh([&](OptionTable& table) { p = parsed(table, apply); });
    return p;
  };
  const std::string defaults = with(from_sets({})).values;
  for (const Renaming& r : renamed) {
    size_t options_of_it = 0;
    for (const Option& o : options) {
      EXPECT_NE(o.path, r.before) << "an old name that is a present one, too";
      if (r.now.empty() || (o.path != r.now && !o.path.starts_with(r.now + "."))) continue;
      ++options_of_it;
      const Written now{o.path, other_value(o)}, before{r.before + o.path.substr(r.now.size()), now.value};
      const Parsed want = with(from_sets({now}));
      EXPECT_EQ(want.complaint, "") << o.path;
      if (o.affects_result) {
        EXPECT_NE(want.values, defaults) << o.path;
      }
      for (const Parsed& p : {with(from_yaml(nested(before))), with(from_sets({before}))}) {
        EXPECT_EQ(p.complaint, "") << before.path;
        EXPECT_EQ(p.values, want.values) << before.path;
        ASSERT_EQ(p.warnings.size(), 1u) << before.path;
        EXPECT_NE(p.warnings[0].find("'" + r.before), std::string::npos) << p.warnings[0];
        EXPECT_NE(p.warnings[0].find("'" + r.now), std::string::npos) << p.warnings[0];
      }
      for (const auto& both : {std::vector{before, now}, std::vector{now, before}})
        EXPECT_NE(with(from_sets(both)).complaint.find("the old and the new name"), std::string::npos) << before.path;
    }
    if (!r.now.empty()) {
      EXPECT_GT(options_of_it, 0u) << r.before << " is now called " << r.now << ", which is neither an option nor a group";
      continue;
    }
    for (const Parsed& p : {with(from_yaml(nested({r.before, "1"}))), with(from_sets({{r.before, "1"}}))}) {
      EXPECT_EQ(p.complaint, "") << r.before;
      EXPECT_EQ(p.values, defaults) << r.before;
      ASSERT_EQ(p.warnings.size(), 1u) << r.before;
      EXPECT_NE(p.warnings[0].find("'" + r.before + "' has no effect any more"), std::string::npos) << p.warnings[0];
    }
  }
}

}  // namespace vitrine::test
