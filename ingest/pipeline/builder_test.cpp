#include "ingest/pipeline/builder.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

namespace diaphane::ingest {
namespace {

namespace fs = std::filesystem;

/// A builder whose child is a shell script.
class BuilderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "diaphane-builder-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    root_ = pattern;
    fs::create_directories(root_ / "uploads");
    options_.program = (root_ / "child").string();
    options_.scratch_dir = options_.volume_dir = root_.string();
    options_.reserve_mb = 0;
    std::ofstream(root_ / "uploads" / "there.tar") << "upload";
  }
  void TearDown() override { fs::remove_all(root_); }

  void child_does(const std::string& script) {
    std::ofstream(root_ / "child") << "#!/bin/sh\n" << script << '\n';
    fs::permissions(root_ / "child", fs::perms::owner_all);
  }
  Result<Build> build(const std::string& name = "there") {
    return builder_->build({(root_ / "uploads" / (name + ".tar")).string(), {}},
                           [] { return true; });
  }

  fs::path root_;
  SandboxBuilder::Options options_;
  std::optional<SandboxBuilder> builder_{};
};

constexpr const char* kRefuses = R"(printf '\n{"code":"scout","text":"A scout."}' >&5)";

TEST_F(BuilderTest, MissingFileIsFinalOnlyIfTheDiskIsMounted) {
  child_does(kRefuses);
  builder_.emplace(options_);
  EXPECT_FALSE(build("missing")) << "nothing was ever found here";
  auto there = build();
  ASSERT_TRUE(there);
  EXPECT_EQ(there->verdict.code, "scout");
  auto missing = build("missing");
  ASSERT_TRUE(missing);
  EXPECT_TRUE(missing->file_missing);

  // The disk is unmounted: its mount point is another directory, or missing.
  fs::rename(root_ / "uploads", root_ / "elsewhere");
  EXPECT_FALSE(build());
  fs::create_directories(root_ / "uploads");
  EXPECT_FALSE(build());
  EXPECT_EQ(build().error().code, ErrorCode::kUnavailable);
  fs::remove(root_ / "uploads");
  fs::rename(root_ / "elsewhere", root_ / "uploads");
  EXPECT_TRUE(build());
}

TEST_F(BuilderTest, CrashIsAVerdictOnlyAfterTheInputWasRead) {
  child_does("kill -SEGV $$");
  builder_.emplace(options_);
  EXPECT_FALSE(build()) << "it had not begun";
  child_does(R"(printf '\n' >&5; kill -SEGV $$)");
  auto crashed = build();
  ASSERT_TRUE(crashed);
  EXPECT_EQ(crashed->verdict.code, "unreadable");
}

TEST_F(BuilderTest, ChildWithoutMemoryOrDiskGivesNoVerdict) {
  child_does(R"(printf '\n' >&5; exit 71)");
  builder_.emplace(options_);
  auto without = build();
  ASSERT_TRUE(without);
  EXPECT_TRUE(without->no_memory);
  child_does(R"(printf '\n' >&5; exit 74)");
  EXPECT_EQ(build().error().code, ErrorCode::kUnavailable);
  child_does(R"(printf '\n' >&5; kill -KILL $$)");
  auto killed = build();
  ASSERT_TRUE(killed);
  EXPECT_TRUE(killed->killed);
}

}  // namespace
}  // namespace diaphane::ingest
