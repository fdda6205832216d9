#include "bench/load/load_report.h"

#include <cstdio>
#include <nlohmann/json.hpp>

namespace diaphane::api::load {
namespace {

using Json = nlohmann::ordered_json;

double grown(const Samples& before, const Samples& after, const std::string& name) {
  return value_of(after, name) - value_of(before, name);
}

Json milliseconds(std::vector<double>& seconds) {
  return {{"p50", 1e3 * percentile(seconds, 50)},
          {"p95", 1e3 * percentile(seconds, 95)},
          {"p99", 1e3 * percentile(seconds, 99)},
          {"mean", 1e3 * mean(seconds)}};
}

double ratio(double over, double under) { return under > 0 ? over / under : 0; }

// Returns average times in milliseconds of a frame that answers an input. renderd measures from the
// arrival of the input to handing the frame to gRPC. The rest of the viewer's latency is transport
// in both directions: gateway, sockets, and threads of both programs.
Json where_the_time_goes(const Measurements& measurements, const Usage& before,
                         const Usage& after) {
  const std::string name = "diaphane_renderd_input_to_frame_seconds";
  const double there = ratio(grown(before.worker, after.worker, name + "_sum"),
                             grown(before.worker, after.worker, name + "_count"));
  const double all = mean(measurements.answer_seconds);
  const double render = mean(measurements.render_seconds);
  const double encode = mean(measurements.encode_seconds);
  return {{"from_oldest_input", 1e3 * all},
          {"render", 1e3 * render},
          {"encode", 1e3 * encode},
          {"wait_in_renderd", 1e3 * (there - render - encode)},
          {"send", 1e3 * (all - there)}};
}

Json device(const Usage& before, const Usage& after, double seconds) {
  Json parts;
  for (const char* part : {"busy", "rendering", "scenes", "pictures", "deciding", "idle"}) {
    const std::string name =
        std::string("diaphane_renderd_device_seconds_total{part=\"") + part + "\"}";
    parts[part] = ratio(grown(before.worker, after.worker, name), seconds);
  }
  return parts;
}

}  // namespace

Json load_report(const CrowdOptions& options, CrowdResult result, const Usage& before,
                 const Usage& after) {
  Measurements& measurements = result.measurements;
  const double wall = std::chrono::duration<double>(after.at - before.at).count();
  const std::size_t unanswered =
      measurements.inputs - std::min(measurements.inputs, measurements.input_to_frame.size());
  Json closed = Json::object();
  for (const auto& [code, count] : result.closed) closed[std::to_string(code)] = count;
  Json report{{"sessions", options.sessions},
              {"moving", options.moving},
              {"width", options.viewer.width},
              {"height", options.viewer.height},
              {"seconds", result.seconds},
              {"opened", result.opened},
              {"refused", result.refused},
              {"closed", closed},
              {"problems", result.problems},
              {"inputs", measurements.inputs},
              {"not_measured", unanswered},
              {"input_to_frame_ms", milliseconds(measurements.input_to_frame)},
              {"opening_ms", milliseconds(result.opening_seconds)},
              {"mean_ms", where_the_time_goes(measurements, before, after)}};
  report["moving_frames_per_second"] =
      ratio(double(measurements.moving_frames), measurements.moving_seconds);
  report["moving_frame_bytes"] =
      ratio(double(measurements.moving_bytes), double(measurements.moving_frames));
  report["moving_frame_pixels"] = ratio(measurements.pixels, double(measurements.moving_frames));
  report["frames_per_second"] = ratio(double(measurements.frames), result.seconds);
  report["megabytes_per_second"] = ratio(double(measurements.bytes) * 1e-6, result.seconds);
  report["cores"] = {{"renderd", ratio(after.renderd - before.renderd, wall)},
                     {"gateway", ratio(after.gateway - before.gateway, wall)},
                     {"redis", ratio(after.redis - before.redis, wall)},
                     {"viewers", ratio(after.viewers - before.viewers, wall)}};
  report["encoding_cores"] =
      ratio(grown(before.worker, after.worker, "diaphane_renderd_encode_seconds_total"), wall);
  report["device"] = device(before, after, wall);
  return report;
}

std::string load_heading() {
  return "sessions moving |  p50   p95   p99 ms | frames/s MB/s | render encode wait  send ms | "
         "device: busy render scene pict. | cores: renderd gateway viewers";
}

std::string load_line(const Json& r) {
  const auto number = [&](const char* a, const char* b) { return r.at(a).at(b).get<double>(); };
  char line[256];
  std::snprintf(line, sizeof line,
                "%8d %6d | %5.1f %5.1f %5.1f | %8.1f %4.0f | %6.1f %6.1f %5.1f %5.1f | %12.2f "
                "%6.2f %5.2f %5.2f | "
                "%14.2f %7.2f %7.2f",
                r.at("sessions").get<int>(), r.at("moving").get<int>(),
                number("input_to_frame_ms", "p50"), number("input_to_frame_ms", "p95"),
                number("input_to_frame_ms", "p99"), r.at("moving_frames_per_second").get<double>(),
                r.at("megabytes_per_second").get<double>(), number("mean_ms", "render"),
                number("mean_ms", "encode"), number("mean_ms", "wait_in_renderd"),
                number("mean_ms", "send"), number("device", "busy"), number("device", "rendering"),
                number("device", "scenes"), number("device", "pictures"),
                number("cores", "renderd"), number("cores", "gateway"), number("cores", "viewers"));
  std::string text = line;
  if (r.at("opened") != r.at("sessions")) {
    text += "  only " + std::to_string(r.at("opened").get<int>()) + " opened";
  }
  if (!r.at("closed").empty()) text += "  closed: " + r.at("closed").dump();
  return text;
}

}  // namespace diaphane::api::load
