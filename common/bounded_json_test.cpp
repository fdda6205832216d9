#include "common/bounded_json.h"

#include <gtest/gtest.h>

#include <string>

namespace diaphane {
namespace {

std::string nested(int depth) { return std::string(depth, '[') + std::string(depth, ']'); }

std::string repeated(const char* part, int count) {
  std::string text = "[";
  for (int i = 0; i < count; ++i) text += std::string(i == 0 ? "" : ",") + part;
  return text + "]";
}

JsonFault fault_of(const std::string& text, const JsonLimits& limits) {
  const auto parsed = parse_json(text, limits);
  EXPECT_FALSE(parsed.has_value()) << text.substr(0, 80);
  return parsed ? JsonFault::kMalformed : parsed.error();
}

TEST(BoundedJson, ParsesDocumentWithinTheLimits) {
  const auto parsed = parse_json(R"({"a": [1, 2.5, "x", null, true, {"b": -1}]})", {9, 3});
  ASSERT_TRUE(parsed.has_value());
  EXPECT_EQ((*parsed)["a"][5]["b"], -1);
  EXPECT_TRUE(parse_json(nested(64), {64}).has_value());
  EXPECT_TRUE(parse_json("7", {1, 0}).has_value());
}

TEST(BoundedJson, RefusesNestingBeyondTheLimit) {
  EXPECT_EQ(fault_of(nested(65), {1000}), JsonFault::kTooDeep);
  // A quarter of a million levels overflow any stack when such a value is copied or written.
  EXPECT_EQ(fault_of(nested(250'000), {1'000'000}), JsonFault::kTooDeep);
  std::string objects;
  for (int i = 0; i < 100'000; ++i) objects += R"({"":)";
  EXPECT_EQ(fault_of(objects, {1'000'000}), JsonFault::kTooDeep) << "never closed";
}

TEST(BoundedJson, CountsEveryKindOfValue) {
  for (const char* part : {"0", "-1", "1.5", "true", "null", "\"\"", "[]", "{}"}) {
    EXPECT_TRUE(parse_json(repeated(part, 99), {100}).has_value()) << part;
    EXPECT_EQ(fault_of(repeated(part, 100), {100}), JsonFault::kTooManyValues) << part;
  }
  EXPECT_EQ(fault_of(R"({"a": 1, "a": 2, "a": 3})", {3}), JsonFault::kTooManyValues);
}

TEST(BoundedJson, RefusesMalformedJson) {
  for (const char* text : {"", " ", "{", "[1,]", "{\"a\"}", "1 2", "nul", "\"\xff\"", "1e999"}) {
    EXPECT_EQ(fault_of(text, {100}), JsonFault::kMalformed) << text;
  }
}

}  // namespace
}  // namespace diaphane
