#include "common/bounded_json.h"

#include <optional>
#include <string>

namespace diaphane {
namespace {

using nlohmann::json;

/// Counts the values of a text without building them, and stops at the first limit.
class LimitCheck final : public nlohmann::json_sax<json> {
 public:
  explicit LimitCheck(const JsonLimits& limits) : limits_(limits) {}

  bool null() override { return value(); }
  bool boolean(bool /*flag*/) override { return value(); }
  bool number_integer(number_integer_t /*number*/) override { return value(); }
  bool number_unsigned(number_unsigned_t /*number*/) override { return value(); }
  bool number_float(number_float_t /*number*/, const string_t& /*text*/) override {
    return value();
  }
  bool string(string_t& /*text*/) override { return value(); }
  bool binary(binary_t& /*bytes*/) override { return value(); }
  bool key(string_t& /*name*/) override { return true; }
  bool start_object(std::size_t /*size*/) override { return open(); }
  bool end_object() override { return close(); }
  bool start_array(std::size_t /*size*/) override { return open(); }
  bool end_array() override { return close(); }
  bool parse_error(std::size_t /*position*/, const std::string& /*token*/,
                   const nlohmann::detail::exception& /*error*/) override {
    return stop(JsonFault::kMalformed);
  }

  std::optional<JsonFault> fault() const { return fault_; }

 private:
  bool stop(JsonFault why) {
    fault_ = why;
    return false;
  }
  bool value() { return ++values_ <= limits_.values || stop(JsonFault::kTooManyValues); }
  bool open() { return value() && (++depth_ <= limits_.depth || stop(JsonFault::kTooDeep)); }
  bool close() {
    --depth_;
    return true;
  }

  const JsonLimits limits_;
  std::size_t values_ = 0;
  int depth_ = 0;
  std::optional<JsonFault> fault_;
};

}  // namespace

tl::expected<json, JsonFault> parse_json(std::string_view text, const JsonLimits& limits) {
  LimitCheck check(limits);
  json::sax_parse(text, &check);
  if (const auto fault = check.fault()) return tl::unexpected(*fault);
  return json::parse(text);
}

}  // namespace diaphane
