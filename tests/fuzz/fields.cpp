// Any bytes as the body of a request, read as every kind of field, and as query parameters, headers
// and upload metadata. Refusals are turned into responses.
#include <algorithm>
#include <array>

#include "api/routing/problem_document.h"
#include "common/bounded_json.h"
#include "tests/fuzz/requests.h"
#include "volume/region.h"

using namespace diaphane;
using namespace diaphane::api;

namespace {

void answered(const Problem& problem) {
  const Response response = problem_response(problem, "fuzz");
  MUST(response.status >= 400 && response.status < 500);
  MUST(nlohmann::json::accept(response.body));
}

void read_region(const nlohmann::json& keep) {
  const auto region = volume::region_from_json(keep.dump());
  if (!region) {
    MUST(!region.error().field.empty());
    return;
  }
  const auto again = volume::region_from_json(volume::to_json(*region));
  MUST(again && again->low == region->low && again->planes.size() == region->planes.size());
}

void read_body(const Request& request) {
  static constexpr std::array<std::string_view, 2> kKnown{"one", "two"};
  Fields in(request);
  MUST(in.text("text", 1, 10).size() <= request.body.size());
  (void)in.text_or("text_or", "else", 10);
  (void)in.prose_or("prose", "", 10);
  (void)in.choice("choice", kKnown);
  (void)in.boolean("boolean");
  (void)in.secret("secret", 20);
  (void)in.is_null("null");
  const auto whole = in.integer("integer", -5, 1000);
  MUST(whole >= -5 && whole <= 1000);
  (void)in.integer_or("integer_or", 1, 0, INT64_MAX);
  (void)in.optional_integer("optional_integer", INT64_MIN, INT64_MAX);
  (void)in.optional_boolean("optional_boolean");
  const nlohmann::json& any = in.any("any");
  MUST(fuzz::depth_of(any) < kDeepestJson);
  read_region(any);
  if (const auto wrong = in.finish()) answered(*wrong);
}

void read_beside(const std::string& text) {
  Request request;
  request.query["x"] = text;
  request.headers["idempotency-key"] = text;
  static constexpr std::array<std::string_view, 1> kKnown{"one"};
  if (const auto number = integer_in_query(request, "x", 1, 0, 100)) {
    MUST(*number >= 0 && *number <= 100);
  }
  if (const auto said = text_in_query(request, "x", 10)) MUST(is_utf8(*said));
  (void)choice_in_query(request, "x", kKnown);
  if (const auto cursor = cursor_in_query(request); cursor && *cursor) {
    MUST(encode_cursor(**cursor) == text);
  }
  (void)time_of(text);
  if (const auto key = idempotency_key(request)) MUST(is_utf8(*key));
  Fields in("Upload-Metadata", {{"title", text}});
  const std::string title = in.text_or("title", "", 200);
  if (const auto wrong = in.finish()) {
    answered(*wrong);
  } else {
    MUST(is_utf8(title));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  read_body(fuzz::request_of("application/json", text));
  read_beside(text);
  return 0;
}
