#include "ingest/cli/scan/report.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "volume/header.h"

namespace diaphane::scan {
namespace {

using nlohmann::ordered_json;

std::string counted(std::size_t n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

std::string suitable_line(const dicom::Series& series) {
  const dicom::Assessment& a = series.assessment;
  char text[200];
  std::snprintf(text, sizeof text, "%-4s %-9s %5zu slices   %u x %u x %u   %.3f x %.3f x %.3f mm\n",
                volume::name_of(a.modality), dicom::plane_name(a.direction).c_str(),
                std::size_t{a.size[2]}, a.size[0], a.size[1], a.size[2], a.spacing[0], a.spacing[1],
                a.spacing[2]);
  return text;
}

std::string directions_line(const dicom::Assessment& a) {
  const auto& d = a.direction;
  char text[200];
  std::snprintf(text, sizeof text,
                "     x (%+.3f %+.3f %+.3f)   y (%+.3f %+.3f %+.3f)   z (%+.3f %+.3f %+.3f)\n",
                d[0], d[3], d[6], d[1], d[4], d[7], d[2], d[5], d[8]);
  return text;
}

/// Returns the name of what distinguishes phases, and the unit of its values.
std::pair<const char*, const char*> words_of(volume::PhaseKind kind) {
  switch (kind) {
    case volume::PhaseKind::kTime:
      return {"time", " ms"};
    case volume::PhaseKind::kCycle:
      return {"cycle", " %"};
    case volume::PhaseKind::kEcho:
      return {"echo", " ms"};
    case volume::PhaseKind::kBValue:
      return {"b-value", " s/mm2"};
    case volume::PhaseKind::kIndex:
      break;
  }
  return {"index", ""};
}

/// Returns the phases for programs, or null if there is only one moment.
ordered_json phases_json(const dicom::Assessment& a) {
  if (a.phases.empty()) return {};
  ordered_json values = ordered_json::array();
  for (const volume::Phase& phase : a.phases) values.push_back(phase.value);
  return {{"by", words_of(a.phases.front().kind).first}, {"values", std::move(values)}};
}

std::string phases_line(const dicom::Assessment& a) {
  if (a.phases.empty()) return {};
  const auto [name, unit] = words_of(a.phases.front().kind);
  char text[120];
  std::snprintf(text, sizeof text, "     %zu phases, by %s: %g to %g%s\n", a.phases.size(), name,
                a.phases.front().value, a.phases.back().value, unit);
  return text;
}

std::string paragraph(std::size_t number, const dicom::Series& series) {
  const dicom::Assessment& a = series.assessment;
  char head[16];
  std::snprintf(head, sizeof head, "%3zu. ", number);
  if (!a.suitable) {
    char text[64];
    std::snprintf(text, sizeof text, "%-4s not suitable, %s: ", volume::name_of(a.modality),
                  counted(series.slices.size(), "file", "files").c_str());
    return head + std::string(text) + a.text + "\n";
  }
  std::string text = head + suitable_line(series) + directions_line(a) + phases_line(a);
  for (const std::string& repair : a.repairs) text += "     " + repair + "\n";
  return text;
}

std::string left_out_lines(const dicom::LeftOut& out) {
  std::string text;
  const auto add = [&](std::size_t n, const char* one, const char* many) {
    if (n > 0) text += "     " + counted(n, one, many) + "\n";
  };
  add(out.not_slices, "file is not a CT, MR or PET slice (report, screenshot, plan or dose)",
      "files are not CT, MR or PET slices (reports, screenshots, plans or doses)");
  add(out.damaged, "file is damaged", "files are damaged");
  add(out.unsupported, "file uses an unsupported compression",
      "files use an unsupported compression");
  add(out.too_large, "file is larger than allowed", "files are larger than allowed");
  add(out.not_dicom, "file is not DICOM", "files are not DICOM");
  return text.empty() ? text : "Skipped:\n" + text;
}

ordered_json series_json(const dicom::Series& series) {
  const dicom::Assessment& a = series.assessment;
  ordered_json json;
  json["suitable"] = a.suitable;
  json["modality"] = volume::name_of(a.modality);
  json["files"] = series.slices.size();
  json["slices"] = a.suitable ? a.size[2] : 0;
  json["size"] = a.suitable ? ordered_json(a.size) : ordered_json();
  json["spacing_mm"] = a.suitable ? ordered_json(a.spacing) : ordered_json();
  json["direction"] = a.suitable ? ordered_json(a.direction) : ordered_json();
  json["origin_mm"] = a.suitable ? ordered_json(a.origin) : ordered_json();
  json["plane"] = a.suitable ? ordered_json(dicom::plane_name(a.direction)) : ordered_json();
  json["phases"] = phases_json(a);
  json["repairs"] = a.repairs;
  json["reason"] = a.suitable ? ordered_json() : ordered_json{{"code", a.code}, {"text", a.text}};
  return json;
}

}  // namespace

std::string as_text(const dicom::Scan& scan) {
  const auto suitable = std::count_if(scan.series.begin(), scan.series.end(),
                                      [](const dicom::Series& s) { return s.assessment.suitable; });
  std::string text = counted(scan.files, "file", "files") + ", " +
                     counted(scan.series.size(), "series", "series") + ", " +
                     std::to_string(suitable) + " suitable\n";
  std::size_t number = 0;
  for (const bool accepted : {true, false}) {
    for (const dicom::Series& series : scan.series) {
      if (series.assessment.suitable == accepted) text += paragraph(++number, series);
    }
  }
  return text + left_out_lines(scan.left_out);
}

std::string as_json(const dicom::Scan& scan) {
  ordered_json json;
  json["files"] = scan.files;
  json["series"] = ordered_json::array();
  for (const dicom::Series& series : scan.series) json["series"].push_back(series_json(series));
  const dicom::LeftOut& out = scan.left_out;
  json["left_out"] = {{"not_dicom", out.not_dicom},
                      {"damaged", out.damaged},
                      {"too_large", out.too_large},
                      {"unsupported", out.unsupported},
                      {"not_slices", out.not_slices}};
  const dicom::Choice choice = dicom::choose(scan);
  json["upload"] = {{"suitable", choice.suitable},
                    {"code", choice.code},
                    {"text", choice.text},
                    {"repairs", choice.repairs}};
  return json.dump(2) + "\n";
}

}  // namespace diaphane::scan
