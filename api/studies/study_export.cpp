#include "api/studies/study_export.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "common/ids.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

constexpr const char* kFolder = "studies";
/// Without it, Excel does not read a CSV file as UTF-8.
constexpr const char* kByteOrderMark = "\xef\xbb\xbf";

ordered_json time_text(const std::optional<Time>& time) {
  if (!time) return nullptr;
  return utc_text(*time, "%Y-%m-%dT%H:%M:%SZ");
}

/// The steps of a definition by ID: their kind and their place in the definition.
struct Step {
  std::string kind;
  std::size_t place = 0;
};

std::map<std::string, Step> steps_of(const std::string& definition) {
  std::map<std::string, Step> steps;
  const json parsed = json::parse(definition);
  for (const json& step : parsed["steps"]) {
    steps.emplace(step["id"].get<std::string>(),
                  Step{step["kind"].get<std::string>(), steps.size()});
  }
  return steps;
}

/// Returns the answers in the order of the definition.
Result<std::vector<StudyAnswer>> sorted_answers(StudyStore& store, const Participant& participant,
                                                const std::map<std::string, Step>& steps) {
  auto answers = store.answers(participant.id);
  DIAPHANE_TRY(answers);
  std::erase_if(*answers, [&](const StudyAnswer& one) { return !steps.contains(one.step); });
  std::ranges::sort(*answers, {}, [&](const StudyAnswer& one) { return steps.at(one.step).place; });
  return answers;
}

const char* state_of(const Participant& participant) {
  return participant.finished ? "finished" : "active";
}

/// Quotes a field of a CSV file (RFC 4180).
std::string quoted(const std::string& text) {
  std::string field = "\"";
  for (const char c : text) {
    if (c == '"') field += '"';
    field += c;
  }
  return field + '"';
}

/// Returns a text as a field. A spreadsheet would run a text that begins like a formula, also in
/// full-width characters, so it gets an apostrophe.
std::string csv_text(const std::string& text) {
  constexpr std::array<std::string_view, 11> kFormulas{"=",  "+",  "-",  "@",  "\t", "\r",
                                                       "\n", "＝", "＋", "－", "＠"};
  const bool formula =
      std::ranges::any_of(kFormulas, [&](std::string_view one) { return text.starts_with(one); });
  return quoted(formula ? "'" + text : text);
}

/// Returns the value as a field.
std::string csv_value(const json& value) {
  if (!value.is_string()) return value.dump();
  const auto& text = value.get_ref<const std::string&>();
  return csv_text(text);
}

/// Writes one line for each simple value: the field is its path, such as "trials.0.rating".
void write_fields(std::ostream& out, const std::string& before, const std::string& path,
                  const json& value, std::int64_t duration_ms) {
  if (value.is_structured() && !value.empty()) {
    for (const auto& [key, part] : value.items()) {
      write_fields(out, before, path.empty() ? key : path + "." + key, part, duration_ms);
    }
    return;
  }
  out << before << ',' << path << ',' << (value.is_structured() ? "" : csv_value(value)) << ','
      << duration_ms << "\r\n";
}

constexpr const char* kDictionary =
    "column,type,meaning\r\n"
    "participant,integer,\"Number of the participant in this study, in the order of joining. "
    "Numbers of "
    "participants who withdrew are missing.\"\r\n"
    "language,en or de,Language that the participant chose\r\n"
    "seed,integer,Seed of the order of the steps and of the random views\r\n"
    "day,date,\"Day on which the participant joined, in UTC\"\r\n"
    "state,active or finished,Whether the participant reached the end\r\n"
    "step,text,ID of the step in definition.json\r\n"
    "kind,text,\"Kind of the step: text, rating, colours, order, viewpoint, choice, words or "
    "latency\"\r\n"
    "field,path,\"Part of the answer, such as trials.0.rating; numbers count from 0. Empty for a "
    "text that was "
    "read and for an empty choice.\"\r\n"
    "value,number or text,\"The answer. A text that begins like a formula has an apostrophe before "
    "it.\"\r\n"
    "duration_ms,integer,Time on the step in milliseconds\r\n"
    "rating,integer,Field of rating: the number chosen from low to high\r\n"
    "colours.N.channel,text,Field of colours: the material\r\n"
    "colours.N.from and colours.N.to,#rrggbb,Field of colours: sRGB before and after\r\n"
    "order.N,text,\"Field of order: IDs of the pictures, from least to most comfortable\"\r\n"
    "shown.N,text,Field of order: IDs of the pictures as first shown\r\n"
    "camera.eye.N and start.eye.N,number,\"Field of viewpoint: position of the camera chosen and "
    "at the start, in mm "
    "on the patient's axes; likewise target and up\"\r\n"
    "choice.N,text,Field of choice: IDs of the chosen options\r\n"
    "words,text,Field of words: what the participant wrote\r\n"
    "trials.N.delay_ms,integer,Field of latency: the added delay\r\n"
    "trials.N.time_ms,number,Field of latency: time to do the task\r\n"
    "trials.N.error_degrees,number,Field of latency: angle between the view and the marked part\r\n"
    "trials.N.acceptable,true or false,Field of latency: whether the delay was acceptable\r\n"
    "trials.N.rating,integer,Field of latency: 0 to 10\r\n";

}  // namespace

Result<std::string> StudyExports::new_name(const std::string& ending) const {
  std::error_code error;
  fs::create_directories(path_of(kFolder), error);
  if (error) return fail(ErrorCode::kUnavailable, "The export can't be written at the moment.");
  return std::string(kFolder) + "/" + random_hex(16) + ending;
}

Result<std::string> StudyExports::write_json(const Study& study) {
  const auto steps = steps_of(study.content.definition);
  const auto participants = store_.participants(study.id);
  DIAPHANE_TRY(participants);
  const auto name = new_name(".json");
  DIAPHANE_TRY(name);
  std::ofstream out(path_of(*name), std::ios::binary);
  const ordered_json head{{"id", study.id},
                          {"definition", ordered_json::parse(study.content.definition)},
                          {"opened_at", time_text(study.opened_at)},
                          {"closed_at", time_text(study.closed_at)},
                          {"withdrawn", study.withdrawn}};
  out << R"({"format":"diaphane-study","version":1,"study":)" << head.dump()
      << ",\"participants\":[";
  bool first = true;
  for (const Participant& one : *participants) {
    const auto answers = sorted_answers(store_, one, steps);
    DIAPHANE_TRY(answers);
    const auto recordings = store_.recordings(one.id);
    DIAPHANE_TRY(recordings);
    ordered_json entry{{"number", one.number},     {"language", one.language},
                       {"seed", one.seed},         {"state", state_of(one)},
                       {"day", one.day},           {"recorded", one.recorded},
                       {"answers", json::array()}, {"recordings", json::array()}};
    for (const StudyAnswer& answer : *answers) {
      entry["answers"].push_back({{"step", answer.step},
                                  {"kind", steps.at(answer.step).kind},
                                  {"value", ordered_json::parse(answer.value)},
                                  {"duration_ms", answer.duration_ms}});
    }
    for (const auto& recorded : *recordings) {
      ordered_json recording{{"step", recorded.step}};
      recording.update(ordered_json::parse(recorded.body));
      entry["recordings"].push_back(std::move(recording));
    }
    out << (first ? "" : ",") << entry.dump();
    first = false;
  }
  out << "]}";
  out.close();
  if (out) return *name;
  remove(*name);
  return fail(ErrorCode::kUnavailable, "The export can't be written at the moment.");
}

Result<std::string> StudyExports::write_zip(const Study& study) {
  const auto steps = steps_of(study.content.definition);
  const auto participants = store_.participants(study.id);
  DIAPHANE_TRY(participants);
  const auto name = new_name(".zip"), table = new_name(".csv");
  DIAPHANE_TRY(name);
  DIAPHANE_TRY(table);
  std::ofstream out(path_of(*table), std::ios::binary);
  out << kByteOrderMark
      << "participant,language,seed,day,state,step,kind,field,value,duration_ms\r\n";
  for (const Participant& one : *participants) {
    const auto answers = sorted_answers(store_, one, steps);
    DIAPHANE_TRY(answers);
    for (const StudyAnswer& answer : *answers) {
      const std::string before = std::to_string(one.number) + "," + one.language + "," +
                                 std::to_string(one.seed) + "," + one.day + "," + state_of(one) +
                                 "," + csv_text(answer.step) + "," + steps.at(answer.step).kind;
      write_fields(out, before, "", json::parse(answer.value), answer.duration_ms);
    }
  }
  out.close();
  const auto write = [&]() -> Result<void> {
    if (!out) return fail(ErrorCode::kUnavailable, "The export can't be written at the moment.");
    const auto zip = make_zip_(path_of(*name));
    DIAPHANE_TRY(zip);
    DIAPHANE_TRY((*zip)->add_file("answers.csv", path_of(*table)));
    DIAPHANE_TRY((*zip)->add("data_dictionary.csv", std::string(kByteOrderMark) + kDictionary));
    DIAPHANE_TRY(
        (*zip)->add("definition.json", ordered_json::parse(study.content.definition).dump(2)));
    DIAPHANE_TRY((*zip)->finish());
    return {};
  };
  const auto written = write();
  remove(*table);
  if (written) return *name;
  remove(*name);
  return tl::unexpected(written.error());
}

Result<std::string> StudyExports::write_text(const std::string& text) {
  const auto name = new_name(".json");
  DIAPHANE_TRY(name);
  std::ofstream out(path_of(*name), std::ios::binary);
  out << text;
  out.close();
  if (out) return *name;
  remove(*name);
  return fail(ErrorCode::kUnavailable, "The results can't be written at the moment.");
}

void StudyExports::remove(const std::string& name) const {
  std::error_code error;
  fs::remove(path_of(name), error);
}

void StudyExports::expire() const {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(path_of(kFolder), error)) {
    const auto written = entry.last_write_time(error);
    if (!error && written + kFileLife < fs::file_time_type::clock::now()) {
      fs::remove(entry.path(), error);
    }
  }
}

}  // namespace diaphane::api
