#include "api/studies/analysis_client.h"

#include <curl/curl.h>

#include <cstdio>
#include <memory>

#include "common/log.h"

namespace diaphane::api {
namespace {

constexpr long kMostAnalysisSeconds = 60;
constexpr std::size_t kMostResultBytes = 8 * 1024 * 1024;

/// Appends a part of the response. Returning less than `size` ends the transfer.
std::size_t take(char* bytes, std::size_t, std::size_t size, void* to) {
  auto& results = *static_cast<std::string*>(to);
  if (results.size() + size > kMostResultBytes) return 0;
  results.append(bytes, size);
  return size;
}

Result<std::string> unavailable(const char* why) { return fail(ErrorCode::kUnavailable, why); }

}  // namespace

Result<std::string> AnalysisClient::analyse(const std::string& export_path,
                                            const std::string& language) {
  if (url_.empty()) return unavailable("The analysis of studies is not installed on this server.");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(export_path.c_str(), "rb"),
                                                             std::fclose);
  const std::unique_ptr<CURL, void (*)(CURL*)> curl(curl_easy_init(), curl_easy_cleanup);
  if (!file || !curl || std::fseek(file.get(), 0, SEEK_END) != 0) {
    return unavailable("The results can't be calculated at the moment.");
  }
  const long size = std::ftell(file.get());
  std::rewind(file.get());
  const std::unique_ptr<curl_slist, void (*)(curl_slist*)> headers(
      curl_slist_append(curl_slist_append(nullptr, "Content-Type: application/json"), "Expect:"),
      curl_slist_free_all);
  const std::string url = url_ + "/analyse?language=" + language;
  std::string results;
  curl_easy_setopt(curl.get(), CURLOPT_URL, url.c_str());
  curl_easy_setopt(curl.get(), CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(curl.get(), CURLOPT_PROXY, "");
  curl_easy_setopt(curl.get(), CURLOPT_POST, 1L);
  curl_easy_setopt(curl.get(), CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(size));
  curl_easy_setopt(curl.get(), CURLOPT_READDATA, file.get());
  curl_easy_setopt(curl.get(), CURLOPT_HTTPHEADER, headers.get());
  curl_easy_setopt(curl.get(), CURLOPT_WRITEFUNCTION, take);
  curl_easy_setopt(curl.get(), CURLOPT_WRITEDATA, &results);
  curl_easy_setopt(curl.get(), CURLOPT_TIMEOUT, kMostAnalysisSeconds);
  curl_easy_setopt(curl.get(), CURLOPT_NOSIGNAL, 1L);
  const CURLcode done = curl_easy_perform(curl.get());
  long status = 0;
  curl_easy_getinfo(curl.get(), CURLINFO_RESPONSE_CODE, &status);
  if (done == CURLE_OK && status == 200) return results;
  log::warning("the analysis of a study failed",
               {{"curl", static_cast<int>(done)}, {"status", status}});
  return unavailable("The results can't be calculated at the moment. Try again later.");
}

}  // namespace diaphane::api
