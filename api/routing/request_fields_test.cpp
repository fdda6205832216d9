#include "api/routing/request_fields.h"

#include <gtest/gtest.h>

#include "api/presets/preset_format.h"
#include "common/bounded_json.h"

namespace diaphane::api {
namespace {

Request json_request(std::string body) {
  Request request;
  request.headers["content-type"] = "application/json";
  request.body = std::move(body);
  return request;
}

std::string nested(std::size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); }

std::string with(const std::string& name, const std::string& value) {
  return "{\"" + name + "\":" + value + "}";
}

TEST(Fields, AnyReturnsReferenceToValueAndReportsMissingField) {
  Fields in(json_request(R"({"keep": {"a": [1, 2]}})"));
  const nlohmann::json& keep = in.any("keep");
  EXPECT_EQ(keep["a"][1], 2);
  EXPECT_EQ(&keep, &in.any("keep")) << "a reference: nothing is copied";
  EXPECT_TRUE(in.any("other").is_null());
  const auto wrong = in.finish();
  ASSERT_TRUE(wrong);
  EXPECT_EQ(wrong->kind, ProblemKind::kInvalid);
  EXPECT_EQ(wrong->fields.at(0).field, "other");
}

TEST(Fields, RefusesTooDeeplyNestedBody) {
  for (const std::size_t depth : {std::size_t{kDeepestJson}, std::size_t{250'000}}) {
    Fields in(json_request(with("keep", nested(depth))));
    EXPECT_TRUE(in.any("keep").is_null()) << depth;
    const auto wrong = in.finish();
    ASSERT_TRUE(wrong) << depth;
    EXPECT_EQ(wrong->kind, ProblemKind::kBadRequest);
    EXPECT_NE(wrong->detail.find("64 levels"), std::string::npos) << wrong->detail;
  }
  Fields in(json_request(with("keep", nested(kDeepestJson - 1))));
  EXPECT_TRUE(in.any("keep").is_array());
  EXPECT_FALSE(in.finish());
}

TEST(Fields, RefusesBodyWithTooManyValues) {
  std::string values = "[0";
  for (std::size_t i = 3; i < Fields::kMostValues; ++i) values += ",0";
  const std::string fits = with("list", values + "]"), too_many = with("list", values + ",0]");
  {
    Fields in(json_request(fits));
    EXPECT_TRUE(in.any("list").is_array());
    EXPECT_FALSE(in.finish());
  }
  Fields in(json_request(too_many));
  const auto wrong = in.finish();
  ASSERT_TRUE(wrong);
  EXPECT_EQ(wrong->kind, ProblemKind::kBadRequest);
  EXPECT_NE(wrong->detail.find("32768 JSON values"), std::string::npos) << wrong->detail;
  Fields wider(json_request(too_many), Fields::kMostValues + 1);
  EXPECT_TRUE(wider.any("list").is_array());
}

TEST(TimeOf, ParsesOnlyTimesThatTheClockCanRepresent) {
  ASSERT_TRUE(time_of("2026-11-22T10:00:00.5Z"));
  EXPECT_EQ(std::chrono::system_clock::to_time_t(*time_of("2026-11-22T10:00:00.5Z")), 1795341600);
  EXPECT_TRUE(time_of("2200-12-31T23:59:59Z"));
  for (const char* text : {"2570-11-22T10:00:00Z", "0001-01-01T00:00:00Z", "9999-12-31T23:59:59Z",
                           "1969-12-31T23:59:59Z", "2026-02-31T00:00:00Z", "now"}) {
    EXPECT_FALSE(time_of(text)) << text;
  }
}

TEST(PresetFormat, NamesSceneFieldWhenSceneIsNestedToTheLimit) {
  Fields in(json_request(with("scene", with("camera", nested(kDeepestJson - 2)))));
  EXPECT_TRUE(read_scene(in).empty());
  const auto wrong = in.finish();
  ASSERT_TRUE(wrong);
  EXPECT_EQ(wrong->kind, ProblemKind::kInvalid);
  EXPECT_TRUE(wrong->fields.at(0).field.starts_with("scene")) << wrong->fields.at(0).field;
}

}  // namespace
}  // namespace diaphane::api
