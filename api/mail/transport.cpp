#include "api/mail/transport.h"

#include <curl/curl.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "api/accounts/password.h"
#include "api/shared/time.h"
#include "common/ids.h"

namespace diaphane::api {
namespace {

std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
  return text;
}

/// Encodes a non-ASCII header text as encoded words (RFC 2047) without splitting a character.
std::string header_text(const std::string& text) {
  if (std::all_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x80; })) return text;
  constexpr std::size_t kWordLetters = 60;  // an encoded word has at most 75 characters
  constexpr char kHex[] = "0123456789ABCDEF";
  std::string words, word;
  const auto end_word = [&] {
    words += (words.empty() ? "=?UTF-8?Q?" : "\r\n =?UTF-8?Q?") + word + "?=";
    word.clear();
  };
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool begins_character = (byte & 0xc0) != 0x80;
    if (begins_character && word.size() + 12 > kWordLetters) end_word();
    if ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9')) {
      word += c;
    } else {
      word += {'=', kHex[byte >> 4], kHex[byte & 15]};
    }
  }
  end_word();
  return words;
}

std::string rfc5322_now() {
  return utc_text(std::chrono::system_clock::now(), "%a, %d %b %Y %H:%M:%S +0000");
}

/// Returns the address in a mailbox of the form "Name <address>" or "address".
std::string address_in(const std::string& mailbox) {
  const std::size_t open = mailbox.rfind('<');
  if (open == std::string::npos) return mailbox;
  return mailbox.substr(open + 1, mailbox.find('>', open) - open - 1);
}

std::string crlf_lines(std::string_view text) {
  std::string lines;
  for (const char c : text) {
    if (c == '\n') lines += '\r';
    if (c != '\r') lines += c;
  }
  return lines;
}

/// Writes one file per email. The names sort in the order of sending.
class FileTransport final : public MailTransport {
 public:
  FileTransport(std::string directory, std::string from)
      : directory_(std::move(directory)), from_(std::move(from)) {}

  Result<void> send(const Mail& mail) override {
    const auto broken = [] {
      return fail(ErrorCode::kUnavailable, "the mail directory is not writable");
    };
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    char stamp[48];
    std::snprintf(stamp, sizeof stamp, "%012lld%09ld", static_cast<long long>(now.tv_sec),
                  now.tv_nsec);
    const std::string id = random_hex(8);
    const std::string name = std::string(stamp) + "-" + id + ".eml";
    const std::filesystem::path path = std::filesystem::path(directory_) / name;
    // The file stays hidden until it is complete, so that readers never see a partial email.
    const std::filesystem::path temporary = std::filesystem::path(directory_) / ("." + name);
    std::ofstream file(temporary, std::ios::binary);
    ::chmod(temporary.c_str(), 0600);  // the email may contain a secret link
    file << message_of(mail, from_, rfc5322_now(), id);
    file.close();
    std::error_code error;
    if (file) std::filesystem::rename(temporary, path, error);
    if (!file || error) {
      std::filesystem::remove(temporary, error);
      return broken();
    }
    return {};
  }

 private:
  std::string directory_, from_;
};

struct Reading {
  std::string text;
  std::size_t at = 0;
};

std::size_t read_some(char* buffer, std::size_t size, std::size_t count, void* user) {
  auto& reading = *static_cast<Reading*>(user);
  const std::size_t some = std::min(size * count, reading.text.size() - reading.at);
  std::copy_n(reading.text.data() + reading.at, some, buffer);
  reading.at += some;
  return some;
}

class SmtpTransport final : public MailTransport {
 public:
  SmtpTransport(std::string url, std::string user, std::string password, std::string from)
      : url_(std::move(url)),
        user_(std::move(user)),
        password_(std::move(password)),
        from_(std::move(from)) {}

  Result<void> send(const Mail& mail) override {
    const std::unique_ptr<CURL, decltype(&curl_easy_cleanup)> curl(curl_easy_init(),
                                                                   &curl_easy_cleanup);
    if (!curl) return fail(ErrorCode::kUnavailable, "cannot initialise the SMTP client");
    Reading reading{message_of(mail, from_, rfc5322_now(), random_hex(16)), 0};
    const std::unique_ptr<curl_slist, decltype(&curl_slist_free_all)> recipients(
        curl_slist_append(nullptr, ("<" + one_line(mail.recipient) + ">").c_str()),
        &curl_slist_free_all);
    CURL* const c = curl.get();
    curl_easy_setopt(c, CURLOPT_URL, url_.c_str());
    curl_easy_setopt(c, CURLOPT_PROTOCOLS_STR, "smtp,smtps");
    if (!user_.empty()) {
      curl_easy_setopt(c, CURLOPT_USERNAME, user_.c_str());
      curl_easy_setopt(c, CURLOPT_PASSWORD, password_.c_str());
    }
    // A password is never sent over an unencrypted connection.
    curl_easy_setopt(c, CURLOPT_USE_SSL,
                     static_cast<long>(user_.empty() ? CURLUSESSL_TRY : CURLUSESSL_ALL));
    curl_easy_setopt(c, CURLOPT_MAIL_FROM, ("<" + address_in(from_) + ">").c_str());
    curl_easy_setopt(c, CURLOPT_MAIL_RCPT, recipients.get());
    curl_easy_setopt(c, CURLOPT_READFUNCTION, read_some);
    curl_easy_setopt(c, CURLOPT_READDATA, &reading);
    curl_easy_setopt(c, CURLOPT_UPLOAD, 1L);
    curl_easy_setopt(c, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(c, CURLOPT_CONNECTTIMEOUT, 10L);
    curl_easy_setopt(c, CURLOPT_TIMEOUT, 60L);
    const CURLcode code = curl_easy_perform(c);
    if (code == CURLE_OK) return {};
    long answer = 0;
    curl_easy_getinfo(c, CURLINFO_RESPONSE_CODE, &answer);
    // 5xx for the recipient is permanent. (530 and 535 concern our own login and may be fixed.)
    const bool permanent = answer >= 550 && answer < 560;
    return fail(permanent ? ErrorCode::kInvalid : ErrorCode::kUnavailable,
                std::string(curl_easy_strerror(code)) + ", SMTP " + std::to_string(answer));
  }

 private:
  std::string url_, user_, password_, from_;
};

std::string percent_decoded(const std::string& text) {
  int size = 0;
  char* const decoded =
      curl_easy_unescape(nullptr, text.c_str(), static_cast<int>(text.size()), &size);
  const std::string result(decoded ? decoded : "", static_cast<std::size_t>(size));
  curl_free(decoded);
  return result;
}

}  // namespace

std::string message_of(const Mail& mail, const std::string& from, const std::string& date,
                       const std::string& message_id) {
  const std::string sender = one_line(address_in(from));
  const std::size_t at = sender.find('@');
  const std::string domain = at == std::string::npos ? "localhost" : sender.substr(at + 1);
  return "Date: " + date + "\r\nFrom: " + one_line(from) + "\r\nTo: <" + one_line(mail.recipient) +
         ">\r\nSubject: " + header_text(one_line(mail.subject)) + "\r\nMessage-ID: <" + message_id +
         "@" + domain +
         ">\r\nAuto-Submitted: auto-generated\r\nMIME-Version: 1.0\r\n"
         "Content-Type: text/plain; charset=utf-8\r\nContent-Transfer-Encoding: 8bit\r\n\r\n" +
         crlf_lines(mail.body);
}

Result<std::unique_ptr<MailTransport>> open_mail_transport(const std::string& setting,
                                                           const std::string& from) {
  if (!is_email(address_in(from)))
    return fail(ErrorCode::kInvalid, "--mail-from: no email address found");
  if (setting.starts_with("file:")) {
    const std::string directory = setting.substr(5);
    std::error_code ignored;
    if (!std::filesystem::is_directory(directory, ignored)) {
      return fail(ErrorCode::kInvalid, "--mail: the directory does not exist");
    }
    return std::make_unique<FileTransport>(directory, from);
  }
  const std::size_t scheme_end = setting.find("://");
  const std::string scheme = setting.substr(0, scheme_end);
  if (scheme_end == std::string::npos || (scheme != "smtp" && scheme != "smtps")) {
    return fail(ErrorCode::kInvalid,
                "--mail: must be file:DIRECTORY or smtp://[user:password@]host:port");
  }
  std::string host = setting.substr(scheme_end + 3);
  std::string user, password;
  if (const std::size_t at = host.rfind('@'); at != std::string::npos) {
    const std::string login = host.substr(0, at);
    host = host.substr(at + 1);
    const std::size_t colon = login.find(':');
    user = percent_decoded(login.substr(0, colon));
    if (colon != std::string::npos) password = percent_decoded(login.substr(colon + 1));
  }
  if (host.empty() || host.find('/') != std::string::npos) {
    return fail(ErrorCode::kInvalid, "--mail: the host is missing");
  }
  curl_global_init(CURL_GLOBAL_DEFAULT);
  return std::make_unique<SmtpTransport>(scheme + "://" + host, user, password, from);
}

}  // namespace diaphane::api
