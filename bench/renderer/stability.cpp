#include "bench/renderer/stability.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/renderer/stability_case.h"

namespace diaphane::render::bench {

std::vector<StabilityRow> measure_stability(Engine& engine, const StabilityOptions& options) {
  std::vector<StabilityRow> rows;
  for (const auto& cases :
       {medium_cases(), ray_cases(), light_cases(), run_cases(), input_cases()}) {
    for (const StabilityCase& one : cases) {
      if (one.about.find(options.only) == std::string::npos) continue;
      StabilityRow row;
      row.about = one.about;
      row.passed = true;
      one.measure(engine, options, row);
      if (row.non_finite > 0) row.passed = false;
      if (options.each) options.each(row);
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

std::string stability_text(const StabilityRow& row, const std::string& engine) {
  char text[400];
  std::snprintf(text, sizeof text, "%-52s %-5s %9.3g %6llu %9.3g %-9s %-6s %s\n", row.about.c_str(),
                engine.c_str(), row.samples, static_cast<unsigned long long>(row.non_finite),
                row.deviation, row.unit.c_str(), row.passed ? "ok" : "WRONG", row.note.c_str());
  return text;
}

std::string stability_json(const std::vector<StabilityRow>& rows, const EngineInfo& engine) {
  nlohmann::ordered_json json{{"bench", "stability"},
                              {"engine", engine.engine},
                              {"device", engine.device},
                              {"rows", nlohmann::ordered_json::array()}};
  for (const StabilityRow& row : rows) {
    json["rows"].push_back({{"case", row.about},
                            {"samples", row.samples},
                            {"non_finite", row.non_finite},
                            {"deviation", nullptr},
                            {"unit", row.unit},
                            {"limit", row.limit},
                            {"passed", row.passed},
                            {"note", row.note}});
    if (std::isfinite(row.deviation)) json["rows"].back()["deviation"] = row.deviation;
  }
  return json.dump(1) + "\n";
}

std::string stability_csv(const std::vector<StabilityRow>& rows, const std::string& engine) {
  std::string text = "case,engine,samples,non_finite,deviation,unit,limit,verdict\n";
  for (const StabilityRow& row : rows) {
    char line[400];
    std::snprintf(line, sizeof line, "\"%s\",%s,%.4g,%llu,%.4g,%s,%g,%s\n", row.about.c_str(),
                  engine.c_str(), row.samples, static_cast<unsigned long long>(row.non_finite),
                  row.deviation, row.unit.c_str(), row.limit, row.passed ? "ok" : "wrong");
    text += line;
  }
  return text;
}

}  // namespace diaphane::render::bench
