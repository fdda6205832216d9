#include "ingest/pipeline/clamd.h"

#include <archive.h>
#include <archive_entry.h>
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <thread>
#include <vector>

namespace diaphane::ingest {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

std::string tar_of(const std::vector<std::string>& contents) {
  std::vector<char> buffer(1 << 22);
  std::size_t used = 0;
  archive* out = archive_write_new();
  archive_write_set_format_pax_restricted(out);
  archive_write_open_memory(out, buffer.data(), buffer.size(), &used);
  for (const std::string& content : contents) {
    archive_entry* e = archive_entry_new();
    archive_entry_set_pathname(e, "file");
    archive_entry_set_filetype(e, AE_IFREG);
    archive_entry_set_size(e, static_cast<la_int64_t>(content.size()));
    archive_write_header(out, e);
    archive_write_data(out, content.data(), content.size());
    archive_entry_free(e);
  }
  archive_write_free(out);
  return {buffer.data(), used};
}

int file_of(const std::string& bytes) {
  const int fd = memfd_create("upload", MFD_CLOEXEC);
  EXPECT_EQ(write(fd, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  return fd;
}

/// A fake clamd that records each stream and gives prepared answers. tests/integration checks the
/// real one's verdicts.
class Listener {
 public:
  enum class Does { kAnswers, kSaysNothing, kHangsUp };

  explicit Listener(std::string answer, Does does = Does::kAnswers)
      : answer_(std::move(answer)), does_(does) {
    std::string pattern = (fs::temp_directory_path() / "diaphane-clamd-XXXXXX").string();
    EXPECT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path().c_str(), sizeof address.sun_path - 1);
    listening_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    EXPECT_EQ(bind(listening_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(listen(listening_, 8), 0);
    thread_ = std::thread([this] { serve(); });
  }
  ~Listener() {
    shutdown(listening_, SHUT_RDWR);
    thread_.join();
    close(listening_);
    for (const int held : held_) close(held);
    fs::remove_all(folder_);
  }
  std::string path() const { return (folder_ / "s").string(); }

  std::vector<std::string> streams;  ///< read after the other side has its answer

 private:
  static bool read_exactly(int fd, char* data, std::size_t bytes) {
    while (bytes > 0) {
      const ssize_t got = read(fd, data, bytes);
      if (got <= 0) return false;
      data += got;
      bytes -= static_cast<std::size_t>(got);
    }
    return true;
  }
  void serve() {
    for (int one = accept(listening_, nullptr, nullptr); one >= 0;
         one = accept(listening_, nullptr, nullptr)) {
      held_.push_back(one);
      char command[10];
      if (does_ == Does::kHangsUp) {
        shutdown(one, SHUT_RDWR);
        continue;
      }
      if (!read_exactly(one, command, sizeof command)) continue;
      EXPECT_EQ(std::string(command, 10), std::string("zINSTREAM\0", 10));
      std::string stream;
      for (std::uint32_t bytes = 1; bytes != 0;) {
        if (!read_exactly(one, reinterpret_cast<char*>(&bytes), 4)) break;
        bytes = ntohl(bytes);
        std::string part(bytes, '\0');
        if (!read_exactly(one, part.data(), bytes)) break;
        stream += part;
      }
      streams.push_back(stream);
      if (does_ == Does::kAnswers) {
        EXPECT_EQ(write(one, answer_.c_str(), answer_.size() + 1),
                  static_cast<ssize_t>(answer_.size() + 1));
      }
    }
  }

  std::string answer_;
  Does does_;
  fs::path folder_;
  int listening_ = -1;
  std::vector<int> held_;
  std::thread thread_;
};

Result<Clamd::Found> look(
    const std::string& address, const std::string& bytes, std::uint64_t most = 1 << 20,
    const Clamd::ShouldContinue& should_continue = [] { return true; }) {
  const int fd = file_of(bytes);
  auto found = Clamd({.address = address, .silence = milliseconds(400), .most_bytes = most})
                   .look_at(fd, should_continue);
  close(fd);
  return found;
}

TEST(Clamd, ScansEachFileOfATarSeparately) {
  Listener clamd("stream: OK");
  const std::vector<std::string> contents{"one", std::string(700'000, 'x'), std::string(512, 'y')};
  const std::string tar = tar_of(contents);
  EXPECT_EQ(look(clamd.path(), tar), Clamd::Found::kClean);
  // The last stream is the end of a tar, which consists of zeros.
  ASSERT_EQ(clamd.streams.size(), contents.size() + 1);
  EXPECT_TRUE(std::equal(contents.begin(), contents.end(), clamd.streams.begin()));
  EXPECT_EQ(clamd.streams.back().find_first_not_of('\0'), std::string::npos);
}

TEST(Clamd, ScansEveryByteOfOtherInput) {
  for (const std::string& odd :
       {std::string("MZ no tar at all"), std::string(1000, '\0') + "behind the end",
        tar_of({"one"}).substr(0, 513), std::string(100, 'x') + tar_of({"shifted"})}) {
    Listener clamd("stream: OK");
    EXPECT_EQ(look(clamd.path(), odd), Clamd::Found::kClean);
    ASSERT_EQ(clamd.streams.size(), 1u);
    EXPECT_EQ(clamd.streams[0], odd);
  }
}

TEST(Clamd, ScansLongFilesInOverlappingParts) {
  std::string content(1'000'000, '\0');
  for (std::size_t i = 0; i < content.size(); ++i) content[i] = static_cast<char>(i * 7919 >> 8);
  const std::uint64_t most = 300'000;
  Listener clamd("stream: OK");
  EXPECT_EQ(look(clamd.path(), tar_of({content}), most), Clamd::Found::kClean);
  clamd.streams.pop_back();
  std::size_t at = 0;
  for (const std::string& part : clamd.streams) {
    ASSERT_LE(part.size(), most);
    ASSERT_EQ(part, content.substr(at, part.size()));
    at += part.size();
    if (at < content.size()) at -= Clamd::kOverlap;
  }
  EXPECT_EQ(at, content.size());
}

TEST(Clamd, ReportsInfection) {
  Listener clamd("stream: Some.Thing-1 FOUND");
  EXPECT_EQ(look(clamd.path(), tar_of({"a", "b"})), Clamd::Found::kInfected);
  EXPECT_EQ(clamd.streams.size(), 1u) << "the rest need not be looked at";
}

TEST(Clamd, NeverReportsCleanWithoutACleanAnswer) {
  for (const char* answer :
       {"INSTREAM size limit exceeded. ERROR", "", "stream: OKAY", "UNKNOWN"}) {
    Listener clamd(answer);
    EXPECT_FALSE(look(clamd.path(), tar_of({"a"}))) << answer;
  }
  Listener silent("", Listener::Does::kSaysNothing);
  EXPECT_FALSE(look(silent.path(), tar_of({"a"})));
  Listener rude("", Listener::Does::kHangsUp);
  EXPECT_FALSE(look(rude.path(), tar_of({"a"})));
  EXPECT_FALSE(look("/nowhere/clamd", tar_of({"a"})));
  EXPECT_FALSE(look("127.0.0.1:1", tar_of({"a"})));
  EXPECT_FALSE(look(std::string(300, 'x'), tar_of({"a"})));
}

TEST(Clamd, StopsWhileClamdIsSilent) {
  Listener silent("", Listener::Does::kSaysNothing);
  int asked = 0;
  EXPECT_EQ(look(silent.path(), tar_of({"a"}), 1 << 20, [&] { return ++asked < 3; }),
            Clamd::Found::kStopped);
  EXPECT_EQ(look("/nowhere/clamd", tar_of({"a"}), 1 << 20, [] { return false; }),
            Clamd::Found::kStopped);
}

}  // namespace
}  // namespace diaphane::ingest
