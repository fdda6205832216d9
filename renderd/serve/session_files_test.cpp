#include <gtest/gtest.h>

#include <thread>

#include "renderd/scene/video_path.h"
#include "tests/support/renderd/test_worker.h"

namespace diaphane::render {
namespace {

using Kind = v1::ServerMessage;
using namespace std::chrono_literals;

struct Viewer : TestViewer {
  v1::Scene scene;

  void key(std::uint32_t index, const v1::Scene& seen) {
    v1::ClientMessage message;
    message.mutable_key_view()->set_index(index);
    *message.mutable_key_view()->mutable_scene() = seen;
    say(message);
  }
  void video(std::uint32_t frames, std::uint32_t side = 64) {
    v1::ClientMessage message;
    v1::Video& video = *message.mutable_file()->mutable_video();
    video.set_path(v1::Video::TURNTABLE);
    video.set_frames(frames);
    video.set_frames_per_second(10);
    video.set_width(side);
    video.set_height(side);
    video.set_error(0.2);
    say(message);
  }
  void picture(std::uint32_t width, std::uint32_t height, double error = 0.2) {
    v1::ClientMessage message;
    v1::LargePicture& picture = *message.mutable_file()->mutable_picture();
    picture.set_width(width);
    picture.set_height(height);
    picture.set_error(error);
    say(message);
  }
  /// Returns the complete file and skips other messages.
  std::string file() {
    std::string bytes;
    for (bool last = false; !last;) {
      const auto message = link->inbox.next_of(Kind::kFilePart);
      if (!message) return {};
      const v1::FilePart& part = message->file_part();
      bytes += part.data();
      last = part.last();
      v1::ClientMessage taken;
      taken.mutable_file_taken()->set_seq(part.seq());
      say(taken);
    }
    return bytes;
  }
};

struct SessionFilesTest : WorkerTest {
  SessionFilesTest() {
    options.host.slots = 4;
    start_worker();
  }
  Viewer attach(const std::string& session, const std::string& participant = {}) {
    Viewer viewer;
    v1::Open open = open_message(session, id, participant);
    open.set_user_id(user);
    viewer.scene = enter(viewer, open).scene();
    v1::ClientMessage hidden;
    hidden.mutable_visibility()->set_visible(false);
    viewer.say(hidden);
    return viewer;
  }
  /// Whether rendering has stopped.
  bool is_quiet() {
    for (int i = 0; i < 100; ++i) {
      const auto samples = device->samples.load();
      std::this_thread::sleep_for(60ms);
      if (device->samples == samples && device->rendering == 0) return true;
    }
    return false;
  }

  const std::string id = store.add_ball();
  const std::string user = new_id();
};

TEST_F(SessionFilesTest, RendersVideoAndChargesTheOwner) {
  device->seconds_per_megapixel = 1;  // 4 ms per sample
  Viewer one = attach(new_id());
  ASSERT_TRUE(is_quiet());
  worker->host().gpu_time().take_milliseconds();
  one.key(0, one.scene);
  one.video(20);
  const std::string video = one.file();
  ASSERT_GT(video.size(), 500u);
  EXPECT_EQ(video.substr(4, 4), "ftyp");
  EXPECT_EQ(one.link->inbox.count(Kind::kFileProgress), 20u);
  const auto spent = worker->host().gpu_time().take_milliseconds();
  ASSERT_TRUE(spent.contains(user));
  EXPECT_GE(spent.at(user), 20u * 4 * 4) << "4 samples at least each of 20 frames";
}

TEST_F(SessionFilesTest, RendersLargeImageInBands) {
  Viewer one = attach(new_id());
  ASSERT_TRUE(is_quiet()) << "its own picture was begun";
  one.key(0, one.scene);
  const int scenes = device->scenes;
  one.picture(4096, 520);
  const std::string png = one.file();
  ASSERT_GT(png.size(), 100u);
  EXPECT_EQ(png.substr(1, 3), "PNG");
  EXPECT_EQ(device->scenes - scenes, 1 + 3) << "a trial, then bands of 256, 256 and 8 rows";
}

TEST_F(SessionFilesTest, DrawsMarksIntoVideosAndLargePictures) {
  Viewer one = attach(new_id());
  ASSERT_TRUE(is_quiet());
  const auto file = [&](bool marked, bool video) {
    one.key(0, one.scene);
    v1::ClientMessage message;
    message.mutable_file_mark()->mutable_mark()->set_kind(v1::Mark::CIRCLE);
    message.mutable_file_mark()->mutable_mark()->set_radius(5);
    if (marked) one.say(message);
    if (video) {
      one.video(2);
    } else {
      one.picture(4096, 64);
    }
    return one.file();
  };
  for (const bool video : {false, true}) {
    const std::string bare = file(false, video);
    EXPECT_EQ(file(false, video), bare);
    const std::string marked = file(true, video);
    EXPECT_GT(marked.size(), 100u);
    EXPECT_NE(marked, bare);
  }
}

TEST_F(SessionFilesTest, CancelledFileStopsRenderingAndFreesItsPlace) {
  device->seconds_per_megapixel = 1;
  const std::string session = new_id();
  for (int way = 0; way < 3; ++way) {
    Viewer one = attach(way == 2 ? new_id() : session);
    one.key(0, one.scene);
    one.video(600);
    ASSERT_TRUE(one.link->inbox.next_of(Kind::kFileProgress));
    if (way == 0) {
      v1::ClientMessage give_up;
      give_up.mutable_file();
      one.say(give_up);
    } else if (way == 1) {
      one.attachment->closed();
    } else {
      worker->host().moved_away(session);
      worker->host().end_all();
    }
    EXPECT_TRUE(is_quiet()) << way;
    EXPECT_EQ(one.link->inbox.count(Kind::kFilePart), 0u);
  }
}

TEST_F(SessionFilesTest, LimitsFilesPerSessionAndPerWorker) {
  device->seconds_per_megapixel = 1;
  Viewer one = attach(new_id()), two = attach(new_id()), three = attach(new_id());
  for (Viewer* viewer : {&one, &two, &three}) viewer->key(0, viewer->scene);
  one.video(600);
  two.video(600);
  three.video(600);
  const auto full = three.problem();
  ASSERT_TRUE(full);
  EXPECT_EQ(full->code(), to_string(ErrorCode::kTooMany));
  EXPECT_EQ(full->field(), "file");
  EXPECT_FALSE(full->fatal());
  one.key(0, one.scene);
  one.video(600);
  const auto busy = one.problem();
  ASSERT_TRUE(busy);
  EXPECT_EQ(busy->code(), to_string(ErrorCode::kConflict));
  one.attachment->closed();
  // The lane releases it within a quantum.
  for (int i = 0; i < 100; ++i) {
    three.key(0, three.scene);
    three.video(600);
    if (three.link->inbox.next_of(Kind::kFileProgress, 100ms)) return;
  }
  FAIL() << "the place was never released";
}

TEST_F(SessionFilesTest, SentFileFreesItsPlace) {
  Viewer one = attach(new_id()), two = attach(new_id()), three = attach(new_id());
  for (Viewer* viewer : {&one, &two, &three, &one}) {
    viewer->key(0, viewer->scene);
    viewer->video(2);
    EXPECT_GT(viewer->file().size(), 100u);
  }
}

TEST_F(SessionFilesTest, NewConnectionReplacesTheFileOfTheOldOne) {
  device->seconds_per_megapixel = 1;
  const std::string session = new_id();
  Viewer before = attach(session);
  before.key(0, before.scene);
  before.video(600);
  ASSERT_TRUE(before.link->inbox.next_of(Kind::kFileProgress));
  Viewer now = attach(session);
  EXPECT_TRUE(before.link->inbox.ended());
  now.key(0, now.scene);
  now.video(2);
  EXPECT_GT(now.file().size(), 100u);
}

TEST_F(SessionFilesTest, RefusesInvalidRequestsAndContinuesTheSession) {
  Viewer one = attach(new_id());
  const auto refused = [&](const char* why) {
    const auto problem = one.problem();
    ASSERT_TRUE(problem) << why;
    EXPECT_EQ(problem->field(), "file") << why;
    EXPECT_FALSE(problem->fatal()) << why;
  };
  one.video(20);
  refused("nothing is seen");
  one.key(0, v1::Scene());
  refused("no scene");
  one.key(3, one.scene);
  refused("a view left out");
  for (std::uint32_t i = 0; i < kMostKeyViews; ++i) one.key(i, one.scene);
  one.key(kMostKeyViews, one.scene);
  refused("a view too many");
  one.video(1'000'000);
  refused("hours");
  one.key(0, one.scene);
  one.video(20, 65);
  refused("odd");
  one.key(0, one.scene);
  one.picture(16385, 16);
  refused("too wide");
  one.key(0, one.scene);
  one.picture(100, 100, std::nan(""));
  refused("no error");
  v1::ClientMessage taken;
  taken.mutable_file_taken()->set_seq(1'000'000);
  one.say(taken);
  v1::ClientMessage give_up;
  give_up.mutable_file();
  one.say(give_up);
  one.key(0, one.scene);
  one.video(2);
  EXPECT_GT(one.file().size(), 100u);
}

TEST_F(SessionFilesTest, RefusesGuests) {
  const std::string session = new_id();
  Viewer owner = attach(session), guest = attach(session, new_id());
  guest.key(0, guest.scene);
  const auto problem = guest.problem();
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->code(), to_string(ErrorCode::kForbidden));
}

TEST_F(SessionFilesTest, AnswersKernelQuery) {
  Viewer one = attach(new_id());
  v1::ClientMessage seen, query;
  seen.mutable_visibility()->set_visible(true);
  one.say(seen);
  query.mutable_kernel();
  one.say(query);
  const auto report = one.link->inbox.next_of(Kind::kKernel);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->kernel().origin(), v1::KernelReport::AHEAD_OF_TIME);
  EXPECT_EQ(one.link->inbox.count(Kind::kKernel), 1u);
}

TEST_F(SessionFilesTest, AnswersErrorCurveQueryAndLimitsItsRate) {
  Viewer one = attach(new_id());
  v1::ClientMessage query;
  query.mutable_error_curve();
  one.say(query);
  EXPECT_TRUE(one.link->inbox.next_of(Kind::kErrorCurve));
  one.say(query);
  const auto problem = one.problem();
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->code(), to_string(ErrorCode::kTooMany));
}

}  // namespace
}  // namespace diaphane::render
