#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/renderer/convergence_report.h"
#include "bench/renderer/growth.h"

namespace diaphane::render::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMega = 1e6;  // MB, not MiB, as in docs/

template <typename... Values>
std::string in_words(const char* form, Values... values) {
  char text[320];
  std::snprintf(text, sizeof text, form, values...);
  return text;
}

double megabytes(const GrowthRow& row) {
  return static_cast<double>(row.volume_bytes + row.acceleration_bytes + row.film_bytes) / kMega;
}

Json number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }
Json json_of(const Timing& t) { return {{"median", t.median}, {"spread", t.spread}}; }

Json json_of(const GrowthRow& row) {
  Json json{{"volume", row.volume},
            {"size", row.size},
            {"width", row.canvas.width},
            {"height", row.canvas.height},
            {"walk", word_of(row.walk)}};
  if (row.left_out) {
    json["left_out"] = *row.left_out;
    return json;
  }
  json["load_ms"] = row.load;
  json["prepare_ms"] = row.prepare;
  json["edit_ms"] = json_of(row.edit);
  json["pass_ms"] = json_of(row.pass);
  json["pass_processor_ms"] = row.processors;
  json["pass_in_a_row_ms"] = row.in_a_row;
  json["to_target"] = nullptr;
  if (row.to_target) {
    json["to_target"] = {{"milliseconds", row.to_target->milliseconds},
                         {"samples", row.to_target->samples},
                         {"how", word_of(row.to_target->how)}};
  }
  json["volume_bytes"] = row.volume_bytes;
  json["acceleration_bytes"] = row.acceleration_bytes;
  json["film_bytes"] = row.film_bytes;
  json["points"] = Json::array();
  for (const CurvePoint& p : row.points) {
    json["points"].push_back({{"samples", p.samples},
                              {"milliseconds", p.milliseconds},
                              {"milliseconds_spread", p.milliseconds_spread},
                              {"estimate", number(p.estimate)}});
  }
  return json;
}

std::string to_target_of(const GrowthRow& row) {
  if (!row.to_target) return "-";
  const char* sign = row.to_target->how == Crossing::How::kFirst       ? "<= "
                     : row.to_target->how == Crossing::How::kProlonged ? "about "
                                                                       : "";
  return in_words("%s%.4g", sign, row.to_target->milliseconds);
}

}  // namespace

std::string growth_heading() {
  return in_words("%-12s %-15s %-10s %-9s %10s %8s %10s %10s %14s %8s %9s %9s %9s %12s\n", "volume",
                  "voxels", "canvas", "walk", "ms a pass", "+-", "processors", "in a row",
                  "to the target", "samples", "load", "prepare", "edit", "memory");
}

std::string growth_text(const GrowthRow& row) {
  const std::string voxels = in_words("%u x %u x %u", row.size[0], row.size[1], row.size[2]);
  const std::string canvas = in_words("%ux%u", row.canvas.width, row.canvas.height);
  std::string text = in_words("%-12s %-15s %-10s %-9s ", row.volume.c_str(), voxels.c_str(),
                              canvas.c_str(), word_of(row.walk));
  if (row.left_out) return text + "left out: " + *row.left_out + '\n';
  return text + in_words("%10.4g %8.2g %10.4g %10.4g %14s %8.3g %9.4g %9.4g %9.4g %9.1f MB\n",
                         row.pass.median, row.pass.spread, row.processors, row.in_a_row,
                         to_target_of(row).c_str(), row.to_target ? row.to_target->samples : NAN,
                         row.load, row.prepare, row.edit.median, megabytes(row));
}

std::string growth_csv(const std::vector<GrowthRow>& rows, const std::string& engine) {
  std::string text =
      "engine,volume,nx,ny,nz,width,height,walk,pass_ms,pass_ms_spread,"
      "pass_processor_ms,pass_in_a_row_ms,to_target_ms,to_target_samples,load_ms,prepare_ms,edit_"
      "ms,edit_ms_spread,volume_bytes,"
      "acceleration_bytes,film_bytes\n";
  for (const GrowthRow& row : rows) {
    if (row.left_out) continue;
    text +=
        in_words("%s,%s,%u,%u,%u,%u,%u,%s,%.6g,%.3g,%.6g,%.6g,", engine.c_str(), row.volume.c_str(),
                 row.size[0], row.size[1], row.size[2], row.canvas.width, row.canvas.height,
                 word_of(row.walk), row.pass.median, row.pass.spread, row.processors, row.in_a_row);
    text += row.to_target
                ? in_words("%.6g,%.4g,", row.to_target->milliseconds, row.to_target->samples)
                : ",,";
    text += in_words("%.6g,%.6g,%.6g,%.3g,%llu,%llu,%llu\n", row.load, row.prepare, row.edit.median,
                     row.edit.spread, static_cast<unsigned long long>(row.volume_bytes),
                     static_cast<unsigned long long>(row.acceleration_bytes),
                     static_cast<unsigned long long>(row.film_bytes));
  }
  return text;
}

std::string growth_json(const std::vector<GrowthRow>& rows, const EngineInfo& info,
                        const GrowthOptions& options) {
  Json json{{"bench", "growth"},          {"engine", info.engine},    {"device", info.device},
            {"repeats", options.repeats}, {"target", options.target}, {"rows", Json::array()}};
  for (const GrowthRow& row : rows) json["rows"].push_back(json_of(row));
  return json.dump(1) + "\n";
}

}  // namespace diaphane::render::bench
