#include "renderd/session/files.h"

#include <gtest/gtest.h>

#include "tests/support/renderd/effects_in_test.h"
#include "tests/support/renderd/test_messages.h"

namespace diaphane::render {
namespace {

using effect::AcknowledgeFile;
using effect::Send;
using effect::StartFile;
using effect::StopFile;

struct FilesTest : testing::Test {
  FilesTest() {
    connection = attach(state, owner(), now)->connection;
    receive(state, connection, hello(), now);
    request.mutable_picture();
    key.set_index(0);
    *key.mutable_scene() = plain_scene();
  }
  Effects ask(std::uint64_t from) {
    return files.handle(FileRequested{from, request, volume}, state);
  }
  Effects say(std::uint64_t file, bool last) {
    v1::ServerMessage message;
    message.mutable_file_part()->set_last(last);
    return files.handle(FileMessage{file, message, last});
  }

  TimePoint now{};
  SessionState state;
  Files files;
  v1::FileRequest request;
  v1::KeyView key;
  std::shared_ptr<const DeviceVolume> volume = std::make_shared<const HostVolume>(volume::Volume());
  std::uint64_t connection = 0;
};

TEST_F(FilesTest, StartsFileWithKeyViewsAndPassesItsMessagesOn) {
  EXPECT_TRUE(files.handle(KeyViewSent{connection, key}, state).empty());
  const auto start = sole<StartFile>(ask(connection));
  EXPECT_EQ(start.keys.size(), 1u);
  EXPECT_EQ(start.volume, volume);
  EXPECT_TRUE(files.makes(start.file));
  EXPECT_EQ(sole<Send>(say(start.file, false)).connection, connection);
  const auto acknowledged = sole<AcknowledgeFile>(files.handle(FileTaken{connection, 4}, state));
  EXPECT_EQ(acknowledged.file, start.file);
  EXPECT_EQ(acknowledged.seq, 4u);
}

TEST_F(FilesTest, NewFirstKeyViewDiscardsMarks) {
  v1::FileMark mark;
  mark.mutable_mark()->set_kind(v1::Mark::TEXT);
  files.handle(KeyViewSent{connection, key}, state);
  EXPECT_TRUE(files.handle(FileMarkSent{connection, mark}, state).empty());
  auto start = sole<StartFile>(ask(connection));
  EXPECT_EQ(start.marks.size(), 1u);
  files.handle(FileRefused{start.file, {}, std::move(start.keys), std::move(start.marks)});
  start = sole<StartFile>(ask(connection));
  EXPECT_EQ(start.marks.size(), 1u) << "not used yet";
  files.handle(FileRefused{start.file, {}, std::move(start.keys), std::move(start.marks)});
  files.handle(KeyViewSent{connection, key}, state);
  EXPECT_TRUE(sole<StartFile>(ask(connection)).marks.empty());
  mark.mutable_mark()->set_colour(8);
  const Effects refused = files.handle(FileMarkSent{connection, mark}, state);
  EXPECT_EQ(sole<Send>(refused).message.problem().field(), "file");
}

TEST_F(FilesTest, FreesReservationAfterLastPartAndTakesNextFile) {
  const auto first = sole<StartFile>(ask(connection));
  EXPECT_EQ(sole<Send>(ask(connection)).message.problem().code(), "conflict");
  const Effects last = say(first.file, true);
  EXPECT_EQ(only<Send>(last).size(), 1u);
  ASSERT_EQ(only<StopFile>(last).size(), 1u);
  EXPECT_EQ(only<StopFile>(last)[0].file, first.file);
  EXPECT_NE(sole<StartFile>(ask(connection)).file, first.file);
}

TEST_F(FilesTest, RefusedFileKeepsKeyViewsThatWereNotUsed) {
  files.handle(KeyViewSent{connection, key}, state);
  auto start = sole<StartFile>(ask(connection));
  const auto problem = sole<Send>(files.handle(
      FileRefused{start.file, {ErrorCode::kTooMany, "Later.", {}}, std::move(start.keys)}));
  EXPECT_EQ(problem.message.problem().field(), "file");
  EXPECT_EQ(sole<StartFile>(ask(connection)).keys.size(), 1u);
}

TEST_F(FilesTest, StopsWithItsViewerAndItsSession) {
  const auto first = sole<StartFile>(ask(connection));
  EXPECT_TRUE(files.handle(ViewerLeft{connection + 1}).empty());
  EXPECT_EQ(sole<StopFile>(files.handle(ViewerLeft{connection})).file, first.file);
  EXPECT_TRUE(say(first.file, false).empty());
  const auto second = sole<StartFile>(ask(connection));
  EXPECT_EQ(sole<StopFile>(files.handle(SessionEnded{})).file, second.file);
}

TEST_F(FilesTest, RequestWithoutKindGivesFileUp) {
  const auto file = sole<StartFile>(ask(connection));
  request.clear_kind();
  EXPECT_EQ(sole<StopFile>(ask(connection)).file, file.file);
}

TEST_F(FilesTest, WaitsForVolumeAndIgnoresViewersWithoutGreeting) {
  const auto loaded = std::exchange(volume, nullptr);
  EXPECT_EQ(sole<Send>(ask(connection)).message.problem().code(), "unavailable");
  volume = loaded;
  JoinRequest join = owner();
  join.participant = "other";
  EXPECT_TRUE(ask(attach(state, join, now)->connection).empty());
}

}  // namespace
}  // namespace diaphane::render
