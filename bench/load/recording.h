#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "api/proto/scene.pb.h"
#include "common/result.h"

namespace diaphane::api::load {

/// A recorded interaction (docs/contracts.md): what a user showed, and when. Plain data.
class Recording {
 public:
  /// Pauses longer than this end a gesture.
  static constexpr double kGestureGap = 0.5;  // seconds

  /// Parses a recording. Fails with kInvalid, which says what is wrong.
  static Result<Recording> read(std::string_view json);

  std::uint32_t width = 0, height = 0;  ///< size of the window in pixels
  std::size_t size() const { return inputs_.size(); }
  diaphane::v1::Scene scene(std::size_t input) const;
  /// Returns the seconds from this input to the next one of its gesture, or 0 if it is the last
  /// one.
  double gap_after(std::size_t input) const;

 private:
  /// One input: a camera and the index of the scene, which many inputs share.
  struct Input {
    double seconds = 0;
    std::size_t scene = 0;
    diaphane::v1::Camera camera;
  };
  Result<void> add(const diaphane::v1::Scene* scene, const diaphane::v1::Camera* camera,
                   double seconds);

  std::vector<diaphane::v1::Scene> scenes_;
  std::vector<Input> inputs_;
};

}  // namespace diaphane::api::load
