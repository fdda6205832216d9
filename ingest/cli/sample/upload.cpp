#include "ingest/cli/sample/upload.h"

#include <curl/curl.h>
#include <sodium.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>
#include <thread>
#include <vector>

#include "common/try.h"

namespace diaphane::sample {
namespace {

using nlohmann::json;

constexpr std::size_t kPart = 8u << 20;  // maximum size of one PATCH
constexpr std::chrono::seconds kPatience{60};

struct Answer {
  long status = 0;  ///< 0: no response
  std::string body;
  std::string offset;  ///< Upload-Offset
};

/// A client for one origin and one token that keeps its connection open.
class Client {
 public:
  explicit Client(const UploadOptions& options)
      : origin_(options.url), authorization_("Authorization: Bearer " + options.token) {
    while (origin_.ends_with('/')) origin_.pop_back();
  }

  Answer send(const char* method, const std::string& path, std::string_view body,
              const std::vector<std::string>& headers) {
    Answer answer;
    CURL* curl = curl_.get();
    if (curl == nullptr) return answer;
    curl_easy_reset(curl);
    curl_slist* list = curl_slist_append(nullptr, authorization_.c_str());
    for (const std::string& header : headers) list = curl_slist_append(list, header.c_str());
    list = curl_slist_append(list, "Expect:");
    const std::unique_ptr<curl_slist, void (*)(curl_slist*)> owned(list, curl_slist_free_all);
    curl_easy_setopt(curl, CURLOPT_URL, (origin_ + path).c_str());
    curl_easy_setopt(curl, CURLOPT_CUSTOMREQUEST, method);
    curl_easy_setopt(curl, CURLOPT_HTTPHEADER, list);
    curl_easy_setopt(curl, CURLOPT_TIMEOUT, 120L);
    curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT, 5L);
    curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(curl, CURLOPT_NOPROXY, "127.0.0.1,localhost,::1");
    curl_easy_setopt(curl, CURLOPT_NOBODY, std::strcmp(method, "HEAD") == 0 ? 1L : 0L);
    if (!body.empty()) {
      curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(body.size()));
      curl_easy_setopt(curl, CURLOPT_POSTFIELDS, body.data());
    }
    curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, &Client::on_body);
    curl_easy_setopt(curl, CURLOPT_WRITEDATA, &answer);
    curl_easy_setopt(curl, CURLOPT_HEADERFUNCTION, &Client::on_header);
    curl_easy_setopt(curl, CURLOPT_HEADERDATA, &answer);
    if (curl_easy_perform(curl) != CURLE_OK) return {};
    curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &answer.status);
    return answer;
  }

 private:
  static std::size_t on_body(char* data, std::size_t one, std::size_t count, void* to) {
    static_cast<Answer*>(to)->body.append(data, one * count);
    return one * count;
  }
  static std::size_t on_header(char* data, std::size_t one, std::size_t count, void* to) {
    std::string line(data, one * count);
    constexpr std::string_view kName = "upload-offset:";
    std::string lower = line.substr(0, kName.size());
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (lower == kName) static_cast<Answer*>(to)->offset = line.substr(kName.size());
    return one * count;
  }

  std::string origin_;
  std::string authorization_;
  std::unique_ptr<CURL, void (*)(CURL*)> curl_{curl_easy_init(), curl_easy_cleanup};
};

/// Turns a problem document into an error message for a person.
tl::unexpected<Error> refusal(const Answer& answer, const char* doing) {
  const json body = json::parse(answer.body, nullptr, false);
  std::string why = "status " + std::to_string(answer.status);
  if (body.is_object()) why = body.value("detail", body.value("title", why));
  return fail(answer.status >= 500 ? ErrorCode::kUnavailable : ErrorCode::kInvalid,
              std::string(doing) + ": " + why);
}

std::string checksum(std::string_view part) {
  std::array<unsigned char, crypto_hash_sha256_BYTES> digest{};
  crypto_hash_sha256(digest.data(), reinterpret_cast<const unsigned char*>(part.data()),
                     part.size());
  std::array<char,
             sodium_base64_ENCODED_LEN(crypto_hash_sha256_BYTES, sodium_base64_VARIANT_ORIGINAL)>
      text{};
  sodium_bin2base64(text.data(), text.size(), digest.data(), digest.size(),
                    sodium_base64_VARIANT_ORIGINAL);
  return "Upload-Checksum: sha256 " + std::string(text.data());
}

Result<void> send_parts(Client& client, const std::string& bundle, const std::string& path,
                        const UploadOptions& options) {
  std::uint64_t sent = 0;
  auto last_progress = std::chrono::steady_clock::now();
  bool ask = false;
  while (sent < bundle.size()) {
    if (std::chrono::steady_clock::now() - last_progress > kPatience) {
      return fail(ErrorCode::kUnavailable, "the upload has stalled");
    }
    Answer answer;
    if (ask) {
      answer = client.send("HEAD", path, {}, {"Tus-Resumable: 1.0.0"});
    } else {
      const std::string_view part = std::string_view(bundle).substr(sent, kPart);
      answer = client.send("PATCH", path, part,
                           {"Tus-Resumable: 1.0.0", "Content-Type: application/offset+octet-stream",
                            "Upload-Offset: " + std::to_string(sent), checksum(part)});
    }
    const bool accepted = answer.status == (ask ? 200 : 204) && !answer.offset.empty();
    if (accepted) {
      const std::uint64_t stands = std::strtoull(answer.offset.c_str(), nullptr, 10);
      if (stands > sent) last_progress = std::chrono::steady_clock::now();
      sent = stands;
      ask = false;
      options.progress(sent, bundle.size());
    } else if (answer.status == 0 || answer.status >= 500 || answer.status == 409 ||
               answer.status == 423 || answer.status == 429 || answer.status == 460) {
      ask = true;  // after a lost connection, asks for the offset and resumes
      std::this_thread::sleep_for(std::chrono::milliseconds(500));
    } else {
      return refusal(answer, "the server refused the upload");
    }
  }
  return {};
}

Result<std::string> wait_until_ready(Client& client, const std::string& id) {
  auto last_answer = std::chrono::steady_clock::now();
  for (;;) {
    const Answer answer = client.send("GET", "/v1/data-sets/" + id, {}, {});
    if (answer.status == 200) {
      last_answer = std::chrono::steady_clock::now();
      const json body = json::parse(answer.body, nullptr, false);
      const std::string state = body.is_object() ? body.value("state", "") : "";
      if (state == "ready") return id;
      if (state == "refused" || state == "expired") {
        const json why = body.value("refusal", json());
        return fail(ErrorCode::kInvalid, why.is_object() ? why.value("text", state) : state);
      }
    } else if (answer.status != 0 && answer.status < 500 && answer.status != 429) {
      return refusal(answer, "cannot read the state of the scan");
    } else if (std::chrono::steady_clock::now() - last_answer > kPatience) {
      return fail(ErrorCode::kUnavailable, "the server does not respond");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(250));
  }
}

}  // namespace

Result<std::string> upload(const std::string& bundle, std::size_t files,
                           const UploadOptions& options) {
  if (sodium_init() < 0) return fail(ErrorCode::kInternal, "cannot initialise libsodium");
  curl_global_init(CURL_GLOBAL_DEFAULT);
  Client client(options);
  const json request{{"title", options.title}, {"bytes", bundle.size()}, {"slices", files}};
  const std::string text = request.dump();
  Answer created;
  for (int attempt = 0; attempt < 20 && (created.status == 0 || created.status >= 500); ++attempt) {
    if (attempt > 0) std::this_thread::sleep_for(std::chrono::milliseconds(500));
    created = client.send("POST", "/v1/data-sets", text, {"Content-Type: application/json"});
  }
  if (created.status == 0)
    return fail(ErrorCode::kUnavailable, "no server responds at this address");
  if (created.status != 201) return refusal(created, "the server refused the scan");
  const json body = json::parse(created.body, nullptr, false);
  if (!body.is_object() || !body.contains("data_set") || !body["data_set"].is_object()) {
    return fail(ErrorCode::kInternal, "the server sent an unexpected response");
  }
  const std::string id = body["data_set"].value("id", "");
  DIAPHANE_TRY(send_parts(client, bundle, body.value("upload_url", ""), options));
  return wait_until_ready(client, id);
}

}  // namespace diaphane::sample
