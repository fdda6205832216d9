#include "api/pacs/gateway_client.h"

#include <curl/curl.h>

#include <memory>

#include "common/log.h"

namespace diaphane::api {
namespace {

/// Longer than the gateway's own limit of a search (pacs/diaphane_pacs/settings.py).
constexpr long kMostGatewaySeconds = 28;
constexpr std::size_t kMostAnswerBytes = 900'000;

/// Appends a part of the response. Returning less than `size` ends the transfer.
std::size_t take(char* bytes, std::size_t, std::size_t size, void* to) {
  auto& answer = *static_cast<std::string*>(to);
  if (answer.size() + size > kMostAnswerBytes) return 0;
  answer.append(bytes, size);
  return size;
}

}  // namespace

Result<ArchiveGateway::Answer> GatewayClient::send(const std::string& path,
                                                   const std::string& body) {
  const std::unique_ptr<CURL, void (*)(CURL*)> curl(curl_easy_init(), curl_easy_cleanup);
  if (!curl) return fail(ErrorCode::kUnavailable, "libcurl is not available");
  curl_slist* list = nullptr;
  for (const std::string& header : {std::string("Content-Type: application/json"),
                                    std::string("Expect:"), "Authorization: Bearer " + key_}) {
    list = curl_slist_append(list, header.c_str());
  }
  const std::unique_ptr<curl_slist, void (*)(curl_slist*)> headers(list, curl_slist_free_all);
  const std::string url = url_ + path;
  Answer answer;
  curl_easy_setopt(curl.get(), CURLOPT_URL, url.c_str());
  curl_easy_setopt(curl.get(), CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(curl.get(), CURLOPT_PROXY, "");
  curl_easy_setopt(curl.get(), CURLOPT_POSTFIELDS, body.c_str());
  curl_easy_setopt(curl.get(), CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(body.size()));
  curl_easy_setopt(curl.get(), CURLOPT_HTTPHEADER, headers.get());
  curl_easy_setopt(curl.get(), CURLOPT_WRITEFUNCTION, take);
  curl_easy_setopt(curl.get(), CURLOPT_WRITEDATA, &answer.body);
  curl_easy_setopt(curl.get(), CURLOPT_TIMEOUT, kMostGatewaySeconds);
  curl_easy_setopt(curl.get(), CURLOPT_NOSIGNAL, 1L);
  const CURLcode done = curl_easy_perform(curl.get());
  long status = 0;
  curl_easy_getinfo(curl.get(), CURLINFO_RESPONSE_CODE, &status);
  answer.status = static_cast<int>(status);
  if (done == CURLE_OK) return answer;
  log::warning("the PACS gateway did not answer", {{"curl", static_cast<int>(done)}});
  return fail(ErrorCode::kUnavailable, "the PACS gateway did not answer");
}

}  // namespace diaphane::api
