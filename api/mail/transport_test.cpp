#include "api/mail/transport.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "common/ids.h"

namespace diaphane::api {
namespace {

using testing::HasSubstr;
using testing::Not;

const Mail kMail{"person@example.org", "Confirm",
                 "First line\n.\nhttps://see.example/verify#token=abc\n"};

/// A mail server for a single connection, with just enough SMTP (RFC 5321). It answers RCPT TO with
/// `to_recipient`.
class OneMailServer {
 public:
  explicit OneMailServer(std::string to_recipient) : to_recipient_(std::move(to_recipient)) {
    listening_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(::bind(listening_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(::listen(listening_, 1), 0);
    ::getsockname(listening_, reinterpret_cast<sockaddr*>(&address), &size);
    port = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~OneMailServer() {
    thread_.join();
    ::close(listening_);
  }
  std::string finish() {
    thread_.join();
    thread_ = std::thread([] {});
    return heard_;
  }
  int port = 0;

 private:
  void say(int peer, const std::string& line) const {
    const std::string text = line + "\r\n";
    EXPECT_EQ(::send(peer, text.data(), text.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(text.size()));
  }
  void serve() {
    const int peer = ::accept(listening_, nullptr, nullptr);
    say(peer, "220 test");
    bool in_data = false;
    std::string line;
    char c = 0;
    while (::recv(peer, &c, 1, 0) == 1) {
      line += c;
      if (c != '\n') continue;
      heard_ += line;
      if (in_data) {
        if (line == ".\r\n") {
          in_data = false;
          say(peer, "250 taken");
        }
      } else if (line.starts_with("EHLO")) {
        say(peer, "250 test");
      } else if (line.starts_with("RCPT")) {
        say(peer, to_recipient_);
      } else if (line.starts_with("DATA")) {
        in_data = true;
        say(peer, "354 go on");
      } else if (line.starts_with("QUIT")) {
        say(peer, "221 bye");
        break;
      } else {
        say(peer, "250 well");
      }
      line.clear();
    }
    ::close(peer);
  }
  const std::string to_recipient_;
  int listening_ = -1;
  std::string heard_;
  std::thread thread_;
};

Result<void> send_to(const OneMailServer& server) {
  auto transport = open_mail_transport("smtp://127.0.0.1:" + std::to_string(server.port),
                                       "Diaphane <diaphane@example.org>");
  EXPECT_TRUE(transport);
  return (*transport)->send(kMail);
}

TEST(Smtp, SendsWholeMessageWithDotStuffing) {
  OneMailServer server("250 well");
  EXPECT_TRUE(send_to(server));
  const std::string heard = server.finish();
  EXPECT_THAT(heard, HasSubstr("MAIL FROM:<diaphane@example.org>"));
  EXPECT_THAT(heard, HasSubstr("RCPT TO:<person@example.org>"));
  EXPECT_THAT(heard, HasSubstr("First line\r\n..\r\nhttps://see.example/verify#token=abc\r\n"));
}

TEST(Smtp, PermanentRecipientErrorIsNotRetried) {
  OneMailServer server("550 no such person");
  const auto sent = send_to(server);
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().code, ErrorCode::kInvalid);
}

TEST(Smtp, TemporaryRecipientErrorIsRetried) {
  OneMailServer server("451 come back later");
  const auto sent = send_to(server);
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().code, ErrorCode::kUnavailable);
}

TEST(Smtp, UnreachableServerIsRetried) {
  const auto sent = (*open_mail_transport("smtp://127.0.0.1:1", "a@b"))->send(kMail);
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().code, ErrorCode::kUnavailable);
}

TEST(Message, EncodesNonAsciiSubjectInShortWords) {
  const Mail mail{"a@b", "Bestätigen Sie Ihre E-Mail-Adresse\r\nBcc: c@d äöüäöüäöüäöü", "Text\n"};
  const std::string message = message_of(mail, "a@b", "now", "1");
  EXPECT_THAT(message, HasSubstr("Subject: =?UTF-8?Q?Best=C3=A4tigen=20Sie=20Ihre"));
  EXPECT_THAT(message, Not(HasSubstr("\r\nBcc")));
  EXPECT_THAT(message, Not(HasSubstr("=C3?=")));
  const std::string head = message.substr(0, message.find("\r\n\r\n"));
  std::istringstream lines(head);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 90u) << line;
}

TEST(FileMail, WritesOneFileThatOnlyItsOwnerCanRead) {
  const auto directory = std::filesystem::temp_directory_path() / ("mail-" + random_hex(8));
  std::filesystem::create_directories(directory);
  ASSERT_TRUE((*open_mail_transport("file:" + directory.string(), "Diaphane <a@b>"))->send(kMail));
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    ++files;
    EXPECT_EQ(entry.path().extension(), ".eml");
    EXPECT_EQ(entry.status().permissions(),
              std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    std::ostringstream text;
    text << std::ifstream(entry.path()).rdbuf();
    EXPECT_THAT(text.str(),
                HasSubstr("\r\n\r\nFirst line\r\n.\r\nhttps://see.example/verify#token=abc"));
  }
  EXPECT_EQ(files, 1);
  std::filesystem::remove_all(directory);
}

TEST(Message, LineBreaksDoNotInjectHeaders) {
  const std::string text =
      message_of({"a@b\r\nBcc: c@d", "s\nX-Evil: 1", "body"}, "x@y\r\nZ: 1", "now", "id");
  const std::string head = text.substr(0, text.find("\r\n\r\n"));
  for (const char* evil : {"\nBcc:", "\nX-Evil:", "\nZ:"}) EXPECT_THAT(head, Not(HasSubstr(evil)));
}

TEST(Setting, InvalidTransportErrorDoesNotQuotePassword) {
  for (const char* bad :
       {"", "file:/nowhere/at/all", "http://x", "smtp://", "smtp://u:hunter2@h/path"}) {
    const auto transport = open_mail_transport(bad, "a@b");
    ASSERT_FALSE(transport) << bad;
    EXPECT_THAT(transport.error().message, Not(HasSubstr("hunter2")));
  }
  EXPECT_FALSE(open_mail_transport("smtp://h:25", "nobody"));
}

}  // namespace
}  // namespace diaphane::api
