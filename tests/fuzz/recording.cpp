// Any bytes as a recorded interaction. An accepted one fits where it is stored and can be returned.
#include "api/presets/recording_format.h"
#include "tests/fuzz/requests.h"

using namespace diaphane;
using namespace diaphane::api;

namespace {

std::optional<Recording> read(std::string_view body) {
  Fields in(fuzz::request_of("application/json", body), kMostRecordingValues);
  Recording recording = read_recording(in);
  if (in.finish()) return std::nullopt;
  return recording;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const auto kept = read({reinterpret_cast<const char*>(data), size});
  if (!kept) return 0;
  MUST(kept->body.size() <= 1'048'576 && is_utf8(kept->body));
  MUST(kept->events >= 1 && kept->events <= 20'000);
  MUST(kept->duration_ms >= 0 && kept->duration_ms <= kept->events * std::int64_t{10'000});
  MUST(fuzz::depth_of(nlohmann::json::parse(kept->body)) <= 16);
  const auto again = read(kept->body);
  MUST(again && again->body == kept->body && again->events == kept->events);
  return 0;
}
