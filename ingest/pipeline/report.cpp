#include "ingest/pipeline/report.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "common/bounded_json.h"
#include "volume/header.h"

namespace diaphane::ingest {
namespace {

using nlohmann::json;

constexpr std::size_t kLongestText = 400;
constexpr std::size_t kMostRepairs = 20;
/// The writer produces six values on two levels, but the child may be compromised.
constexpr JsonLimits kLimits{16, 4};

bool is_code(std::string_view text) {
  return !text.empty() && text.size() <= 40 &&
         text.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == std::string_view::npos;
}

bool is_sentence(std::string_view text) {
  return text.size() <= kLongestText &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

/// Returns whether a text is empty or a DICOM UID.
bool is_uid(std::string_view text) {
  return text.size() <= 64 && text.find_first_not_of("0123456789.") == std::string_view::npos;
}

}  // namespace

Verdict refused(std::string code, std::string text) {
  Verdict verdict;
  verdict.code = std::move(code);
  verdict.text = std::move(text);
  return verdict;
}

Verdict over_quota(std::uint64_t bytes, std::uint64_t left) {
  constexpr std::uint64_t kMegabyte = 1'000'000;
  return refused(
      "over_quota",
      "The 3D image of this scan takes " + std::to_string((bytes + kMegabyte - 1) / kMegabyte) +
          " MB, and " + std::to_string(left / kMegabyte) +
          " MB of your storage are left. Delete other scans, then upload this one again.");
}

std::string write_report(const Verdict& verdict) {
  if (!verdict.ready) return json{{"code", verdict.code}, {"text", verdict.text}}.dump();
  // Only labels need these fields, which are often malformed, so they are dropped and not refused.
  volume::Header clean = verdict.header;
  if (!is_uid(clean.frame_of_reference)) clean.frame_of_reference.clear();
  if (clean.origin && !std::all_of(clean.origin->begin(), clean.origin->end(),
                                   [](double v) { return std::isfinite(v); })) {
    clean.origin.reset();
  }
  auto header = volume::to_json(clean);
  if (!header) return json{{"code", "internal"}, {"text", header.error().message}}.dump();
  return json{{"header", *header},
              {"filler", {verdict.filler.value, verdict.filler.count}},
              {"frame", clean.frame_of_reference}}
      .dump();
}

Result<Verdict> read_report(const std::string& report) {
  const auto bad = [] { return fail(ErrorCode::kInvalid, "the report is invalid"); };
  const auto parsed = parse_json(report, kLimits);
  if (!parsed || !parsed->is_object()) return bad();
  const json& body = *parsed;
  if (!body.contains("header")) {
    const json code = body.value("code", json()), text = body.value("text", json());
    if (!code.is_string() || !text.is_string()) return bad();
    Verdict verdict = refused(code.get<std::string>(), text.get<std::string>());
    if (!is_code(verdict.code) || !is_sentence(verdict.text)) return bad();
    return verdict;
  }
  if (!body["header"].is_string()) return bad();
  auto header = volume::from_json(body["header"].get<std::string>());
  const json frame = body.value("frame", json(""));
  if (!frame.is_string() || !is_uid(frame.get_ref<const std::string&>())) return bad();
  if (!header || !header->content_hash.empty() || !header->label_hash.empty() ||
      !header->frame_of_reference.empty() || header->repairs.size() > kMostRepairs ||
      !std::all_of(header->repairs.begin(), header->repairs.end(), is_sentence)) {
    return bad();
  }
  Verdict verdict;
  verdict.ready = true;
  const json filler = body.value("filler", json());
  if (!filler.is_array() || filler.size() != 2 || !filler[0].is_number_integer() ||
      !filler[1].is_number_unsigned()) {
    return bad();
  }
  verdict.filler = {filler[0].get<std::int16_t>(), filler[1].get<std::uint64_t>()};
  verdict.header = std::move(*header);
  verdict.header.frame_of_reference = frame.get<std::string>();
  return verdict;
}

}  // namespace diaphane::ingest
