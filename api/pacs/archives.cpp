#include "api/pacs/archives.h"

#include "api/accounts/api_tokens.h"
#include "common/ids.h"
#include "common/log.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

/// Counts what runs at the same time.
class Place {
 public:
  explicit Place(std::atomic<int>& count) : count_(count), number_(++count) {}
  ~Place() { --count_; }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;
  int number() const { return number_; }

 private:
  std::atomic<int>& count_;
  int number_;
};

tl::unexpected<Problem> no_gateway() {
  return refuse(ProblemKind::kUnavailable,
                "The connection to the hospital's archives does not work at the moment. Try again "
                "later.",
                std::chrono::seconds(5));
}

/// Returns the problem for the gateway's kind of error (pacs/diaphane_pacs/errors.py).
tl::unexpected<Problem> refused(const std::string& kind) {
  if (kind == "not-found") {
    return refuse(ProblemKind::kNotFound, "There is no such archive, study, series or fetch.");
  }
  if (kind == "unreachable" || kind == "slow") {
    return refuse(ProblemKind::kArchiveUnreachable,
                  "The archive does not respond. Try again later, or ask your administrator.");
  }
  if (kind == "unauthorised") {
    return refuse(ProblemKind::kArchiveRefused,
                  "The archive does not let Diaphane in. Ask your administrator to check the "
                  "credentials.");
  }
  if (kind == "faulty") {
    return refuse(ProblemKind::kArchiveFaulty,
                  "The archive sent an invalid response. Ask your administrator.");
  }
  if (kind == "busy") {
    return refuse(ProblemKind::kTooMany,
                  "Too many fetches are running. Wait until one has finished.",
                  std::chrono::seconds(10));
  }
  return no_gateway();
}

std::string kind_in(const std::string& body) {
  const auto document = Archives::Json::parse(body, nullptr, false);
  return document.is_object() ? document.value("error", "") : std::string();
}

}  // namespace

Outcome<Archives::Json> Archives::ask(const std::string& path, const Json& body) {
  if (!gateway_.installed()) return refused("not-found");
  const auto answer =
      gateway_.send(path, body.dump(-1, ' ', false, Json::error_handler_t::replace));
  if (!answer) return no_gateway();
  if (answer->status != 200) return refused(kind_in(answer->body));
  Json document = Json::parse(answer->body, nullptr, false);
  if (!document.is_object()) return no_gateway();
  return document;
}

Outcome<void> Archives::record(const Principal& who, std::string action,
                               std::vector<AuditDetail> details) {
  const auto done = store_.note({AuditActor::kPerson, who.user_id, std::move(action), "account",
                                 who.user_id, std::move(details)},
                                clock_.wall());
  if (!done) return refuse(done.error());
  return {};
}

Outcome<Archives::Json> Archives::ask_and_record(const Principal& who, const std::string& path,
                                                 const Json& body, const std::string& action,
                                                 std::vector<AuditDetail> details) {
  const Place place(searches_);
  if (place.number() > kMostSearches) return refused("busy");
  auto answer = ask(path, body);
  // An archive that is unknown is not recorded, because its name may be any text.
  if (!answer && answer.error().kind == ProblemKind::kNotFound) return answer;
  if (answer) {
    details.emplace_back("results", static_cast<std::int64_t>((*answer)["items"].size()));
  } else {
    details.emplace_back("failed", std::int64_t{1});
  }
  DIAPHANE_TRY(record(who, action, std::move(details)));
  return answer;
}

Outcome<Archives::Json> Archives::list() {
  if (!gateway_.installed()) return Json{{"items", Json::array()}};
  return ask("/archives", Json::object());
}

Outcome<void> Archives::require(const std::string& archive) {
  const auto known = list();
  DIAPHANE_TRY(known);
  for (const Json& one : (*known)["items"]) {
    if (one.value("name", "") == archive) return {};
  }
  return refused("not-found");
}

Outcome<Archives::Json> Archives::search(const Principal& who, const std::string& archive,
                                         const Search& search) {
  return ask_and_record(who, "/studies",
                        {{"archive", archive},
                         {"patient_name", search.patient_name},
                         {"patient_id", search.patient_id},
                         {"accession", search.accession},
                         {"modality", search.modality},
                         {"from", search.from},
                         {"until", search.until}},
                        "archive.searched", {{"archive", archive}});
}

Outcome<Archives::Json> Archives::series(const Principal& who, const std::string& archive,
                                         const std::string& study) {
  return ask_and_record(who, "/series", {{"archive", archive}, {"study", study}},
                        "archive.study-opened", {{"archive", archive}, {"study", hash(study)}});
}

Outcome<Archives::Json> Archives::fetch(const Principal& who, const std::string& archive,
                                        const Series& series) {
  DIAPHANE_TRY(require(archive));
  const std::string token = std::string(kApiTokenPrefix) + random_hex(32);
  const Time now = clock_.wall();
  const auto begun = store_.begin_fetch(
      who.user_id, blake2b(token), now, now + kFetchLife,
      {AuditActor::kPerson,
       who.user_id,
       "archive.fetch-started",
       "account",
       who.user_id,
       {{"archive", archive}, {"study", hash(series.study)}, {"series", hash(series.series)}}});
  if (!begun) return refuse(begun.error());
  return ask("/fetch", {{"archive", archive},
                        {"account", who.user_id},
                        {"token", token},
                        {"study", series.study},
                        {"series", series.series},
                        {"title", series.title}});
}

Outcome<Archives::Json> Archives::status(const Principal& who, const std::string& archive,
                                         const std::string& id) {
  return ask("/fetch/status", {{"archive", archive}, {"account", who.user_id}, {"id", id}});
}

Outcome<void> Archives::cancel(const Principal& who, const std::string& archive,
                               const std::string& id) {
  const auto done =
      ask("/fetch/cancel", {{"archive", archive}, {"account", who.user_id}, {"id", id}});
  DIAPHANE_TRY(done);
  return record(who, "archive.fetch-cancelled", {{"archive", archive}});
}

Outcome<void> Archives::receive(const Principal& who, const std::string& via,
                                const std::string& study) {
  return record(who, "archive.received", {{"via", via}, {"study", hash(study)}});
}

}  // namespace diaphane::api
