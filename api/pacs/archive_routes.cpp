#include <algorithm>
#include <array>

#include "api/pacs/routes.h"
#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/routing/route_parts.h"
#include "api/shared/audit.h"

namespace diaphane::api {
namespace {

constexpr std::array<std::string_view, 3> kModalities{"CT", "MR", "PT"};
constexpr std::array<std::string_view, 2> kWays{"stow", "dimse"};
constexpr std::size_t kLongestSearchText = 64, kLongestAccession = 16, kLongestUid = 64,
                      kLongestTitle = 200;

bool is_uid(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(),
                                      [](char c) { return (c >= '0' && c <= '9') || c == '.'; });
}

std::string uid_in(Fields& in, const std::string& name) {
  std::string uid = in.text(name, 1, kLongestUid);
  if (!uid.empty() && !is_uid(uid)) in.wrong(name, "must be a DICOM UID");
  return uid;
}

/// Reads an optional date, such as 2026-11-22.
std::string date_in(Fields& in, const std::string& name) {
  std::string date = in.text_or(name, "", 10);
  if (!date.empty() && !time_of(date + "T00:00:00Z"))
    in.wrong(name, "must be a date such as 2026-11-22");
  return date;
}

Outcome<Response> answer_json(const Outcome<Archives::Json>& result, int status = 200) {
  DIAPHANE_TRY(result);
  return json_response(status, *result).with("Cache-Control", "no-store");
}

/// Returns the name of an archive that exists.
Outcome<std::string> archive_in(Archives& archives, const Request& request) {
  const std::string& name = request.parameter("archive");
  if (!is_code_word(name)) return refuse(ProblemKind::kNotFound, "There is no such archive.");
  DIAPHANE_TRY(archives.require(name));
  return name;
}

Outcome<Response> search(Archives& archives, const Request& request, const Principal& who) {
  Fields in(request);
  Archives::Search search;
  search.patient_name = in.text_or("patient_name", "", kLongestSearchText);
  search.patient_id = in.text_or("patient_id", "", kLongestSearchText);
  search.accession = in.text_or("accession", "", kLongestAccession);
  search.from = date_in(in, "from");
  search.until = date_in(in, "until");
  search.modality = in.text_or("modality", "", 2);
  if (!search.modality.empty() &&
      std::find(kModalities.begin(), kModalities.end(), search.modality) == kModalities.end()) {
    in.wrong("modality", "must be one of: CT, MR, PT");
  }
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto archive = archive_in(archives, request);
  DIAPHANE_TRY(archive);
  if (search.patient_name.empty() && search.patient_id.empty() && search.accession.empty() &&
      search.from.empty()) {
    return refuse_field("patient_name",
                        "enter a name, a patient ID, an accession number or a first date");
  }
  return answer_json(archives.search(who, *archive, search));
}

Outcome<Response> list_series(Archives& archives, const Request& request, const Principal& who) {
  Fields in(request);
  const std::string study = uid_in(in, "study");
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto archive = archive_in(archives, request);
  DIAPHANE_TRY(archive);
  return answer_json(archives.series(who, *archive, study));
}

Outcome<Response> fetch(Archives& archives, const Request& request, const Principal& who) {
  Fields in(request);
  Archives::Series series;
  series.study = uid_in(in, "study");
  series.series = uid_in(in, "series");
  series.title = in.text_or("title", "", kLongestTitle);
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto archive = archive_in(archives, request);
  DIAPHANE_TRY(archive);
  return answer_json(archives.fetch(who, *archive, series), 202);
}

Outcome<Response> receive(Archives& archives, Accounts& accounts, const Request& request,
                          const Principal& who) {
  Fields in(request);
  const std::string via = in.choice("via", kWays);
  const std::string study = uid_in(in, "study");
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  DIAPHANE_TRY(archives.receive(who, via, study));
  const auto quota = accounts.quota_of(who.user_id);
  DIAPHANE_TRY(quota);
  return json_response(200,
                       {{"free_bytes", std::max(quota->bytes - quota->used, std::int64_t{0})}});
}

}  // namespace

std::vector<Route> archive_routes(Archives& archives, Accounts& accounts) {
  const auto list = [&archives](const Request&, const Principal&) {
    return answer_json(archives.list());
  };
  const auto find = [&archives](const Request& request, const Principal& who) {
    return search(archives, request, who);
  };
  const auto open = [&archives](const Request& request, const Principal& who) {
    return list_series(archives, request, who);
  };
  const auto start = [&archives](const Request& request, const Principal& who) {
    return fetch(archives, request, who);
  };
  const auto look = [&archives](const Request& request, const Principal& who) -> Outcome<Response> {
    const auto archive = archive_in(archives, request);
    DIAPHANE_TRY(archive);
    return answer_json(archives.status(who, *archive, request.parameter("fetch_id")));
  };
  const auto stop = [&archives](const Request& request, const Principal& who) -> Outcome<Response> {
    const auto archive = archive_in(archives, request);
    DIAPHANE_TRY(archive);
    return answer(archives.cancel(who, *archive, request.parameter("fetch_id")));
  };
  const auto take = [&archives, &accounts](const Request& request, const Principal& who) {
    return receive(archives, accounts, request, who);
  };
  const std::string one = "/v1/archives/{archive}", job = one + "/fetches/{fetch_id}";
  constexpr Access kWho = Access::kArchive;
  return {
      {"GET", "/v1/archives", "listArchives", kWho, list, {}},
      {"POST", one + "/studies", "searchArchive", kWho, find, {}},
      {"POST", one + "/series", "listArchiveSeries", kWho, open, {}},
      {"POST", one + "/fetches", "startFetch", kWho, start, {}},
      {"GET", job, "getFetch", kWho, look, {}},
      {"DELETE", job, "cancelFetch", kWho, stop, {}},
      {"POST", "/v1/archive-receipts", "recordReceipt", kWho, take, {}},
  };
}

}  // namespace diaphane::api
