// Any bytes as messages of one browser to its session, each after its length in two bytes. Accepted
// messages are executed: depth is queried, slices are cut, and the frames of a video are planned.
#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <cmath>

#include "renderd/scene/file_order.h"
#include "renderd/scene/presets.h"
#include "renderd/scene/video_path.h"
#include "renderd/session/depth.h"
#include "renderd/session/state.h"
#include "tests/fuzz/must.h"
#include "tests/support/renderd/test_messages.h"
#include "volume/slices.h"

using namespace diaphane;
using namespace diaphane::render;

namespace {

// A ball of 12 x 10 x 8 voxels, tilted in world space.
const volume::Volume& ball() {
  static const volume::Volume made = [] {
    volume::Volume v;
    v.header.size = {12, 10, 8};
    v.header.spacing = {8, 10, 12};
    v.header.direction = {0, 1, 0, 0, 0, 1, 1, 0, 0};
    for (int z = 0; z < 8; ++z) {
      for (int y = 0; y < 10; ++y) {
        for (int x = 0; x < 12; ++x) {
          const bool inside = std::hypot(x - 5.5, y - 4.5, z - 3.5) < 3.5;
          v.voxels.push_back(inside ? 900 : -1000);
        }
      }
    }
    volume::measure(v);
    return v;
  }();
  return made;
}

class Browser {
 public:
  Browser() {
    state_.requested.scene = std::make_shared<const v1::Scene>(plain_scene());
    const auto attached = attach(state_, owner(), now_);
    MUST(attached.has_value());
    connection_ = attached->connection;
    hear(hello());
  }

  void hear(const v1::ClientMessage& message) {
    now_ += std::chrono::milliseconds(60);
    if (message.has_slices()) return slices(message.slices());
    if (message.has_key_view() || message.has_file_mark() || message.has_file()) {
      return file(message);
    }
    const Outcome outcome = receive(state_, connection_, message, now_);
    if (outcome.problem) MUST(!outcome.problem->message().empty());
    if (!state_.requested.scene) return;
    MUST(check_scene(*state_.requested.scene).has_value());
    MUST(is_sound(state_.requested.viewport) || state_.requested.viewport == Canvas{});
    if (outcome.wake && is_sound(state_.requested.viewport))
      began(state_, ++epoch_, state_.requested);
    if (outcome.depth) depth(*outcome.depth);
  }

 private:
  void depth(const v1::DepthQuery& query) const {
    MUST(query.x() >= 0 && query.x() <= 1 && query.y() >= 0 && query.y() <= 1);
    static const auto coarse = coarse_of(ball());
    if (!state_.shown.scene || !is_sound(state_.shown.viewport)) return;
    const auto visible =
        visible_point_at(*coarse, *state_.shown.scene, state_.shown.viewport, query.x(), query.y());
    if (!visible) return;
    MUST(std::isfinite(visible->distance) && visible->distance >= 0);
    MUST(std::isfinite(visible->place.x + visible->place.y + visible->place.z));
  }

  void slices(const v1::SliceRequest& request) {
    static const SliceStacks stacks = stacks_of(ball().header);
    if (const auto noted = queue_.replace(request, stacks, ball().header); !noted) {
      MUST(!noted.error().field.empty());
      return;
    }
    for (std::size_t sent = 0;; ++sent) {
      const auto due = queue_.take();
      if (!due) return;
      MUST(sent <= stacks.size());
      if (due->curved) {
        MUST(volume::samples_of(ball().header, *due->curved) <= volume::kMostSamples);
        volume::CurvedSlice part = *due->curved;
        part.columns = std::min(part.columns, 8u);
        part.rows = std::min(part.rows, 8u);
        part.thickness = std::min(part.thickness, 16.0);
        MUST(volume::sample(ball(), part).size() == std::size_t{part.columns} * part.rows);
        queue_.depart();
        continue;
      }
      const volume::SliceStack& stack = stacks.at(due->plane);
      if (due->oblique) {
        MUST(volume::samples_of(ball().header, *due->oblique) <= volume::kMostSamples);
        // Few pixels, because a fuzzer needs many runs. Their number changes no access.
        volume::ObliqueSlice part = *due->oblique;
        part.columns = std::min(part.columns, 8u);
        part.rows = std::min(part.rows, 8u);
        part.thickness = std::min(part.thickness, 16.0);
        MUST(volume::sample(ball(), part).size() == std::size_t{part.columns} * part.rows);
        queue_.depart();
        continue;
      }
      const auto values = volume::slice_of(ball(), stack, due->index);
      MUST(values && values->size() == std::size_t{stack.columns} * stack.rows);
      queue_.depart();
    }
  }

  void file(const v1::ClientMessage& message) {
    if (message.has_key_view()) {
      (void)note_key_view(keys_, message.key_view());
      MUST(keys_.size() <= kMostKeyViews);
    } else if (message.has_file_mark()) {
      (void)note_file_mark(marks_, message.file_mark());
      MUST(marks_.size() <= kMostFileMarks);
    } else if (message.file().has_picture()) {
      const v1::LargePicture& picture = message.file().picture();
      if (check_picture(picture, keys_)) {
        MUST(picture.width() <= kLongestCanvas && picture.height() <= kLongestCanvas);
      }
    } else if (message.file().has_video()) {
      video(message.file().video());
    }
  }

  void video(const v1::Video& video) const {
    if (!check_video(video, keys_)) return;
    MUST(video.frames() >= 2 && video.frames() <= kLongestVideoSeconds * 60);
    for (const std::uint32_t frame : {0u, 1u, video.frames() / 2, video.frames() - 1}) {
      const auto sound = check_scene(video_frame(video, keys_, frame));
      if (!sound)
        std::fprintf(stderr, "%s %s\n", sound.error().field.c_str(), sound.error().message.c_str());
      MUST(sound.has_value());
    }
  }

  SessionState state_;
  SliceRequestQueue queue_;
  std::vector<v1::Scene> keys_;
  std::vector<v1::FileMark> marks_;
  TimePoint now_{std::chrono::seconds(1)};
  std::uint64_t connection_ = 0, epoch_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  // Suppresses a message per text that is not UTF-8, among which findings would be lost.
  static auto* const silenced = google::protobuf::SetLogHandler(nullptr);
  (void)silenced;
  Browser browser;
  while (size >= 2) {
    const std::size_t length = std::min<std::size_t>(data[0] + 256 * data[1], size - 2);
    v1::ClientMessage message;
    if (message.ParseFromArray(data + 2, static_cast<int>(length))) browser.hear(message);
    data += 2 + length;
    size -= 2 + length;
  }
  return 0;
}
