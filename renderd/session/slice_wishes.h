#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "api/proto/stream.pb.h"
#include "common/result.h"
#include "volume/slices.h"

namespace diaphane::render {

using SliceStacks = std::array<volume::SliceStack, 3>;  ///< in the order of volume::kPlanes

/// One slice that is due to a viewer.
struct SliceDue {
  std::size_t plane = 0;  ///< number in volume::kPlanes
  std::uint32_t index = 0;
};

/// Which slices one viewer waits for: one of a plane at most, the newest, so that a slow line holds
/// few and never a queue of them. Plain data and arithmetic.
class SliceWishes {
 public:
  static constexpr std::uint64_t kUnderWay = 3;  ///< sent and not yet taken

  /// Takes what a viewer says. kInvalid, naming the field, where it is none of the stacks': then
  /// nothing has changed.
  Result<void> wish(const diaphane::v1::SlicesWanted& wanted, const SliceStacks& stacks);
  /// One can be taken now.
  bool ready() const { return !making_ && waiting() && seq_ - taken_ < kUnderWay; }
  /// The next to be read and coded, one at a time until it was sent or given up; planes in turn.
  std::optional<SliceDue> take();
  /// What was taken leaves now; its sequence number, from 1.
  std::uint64_t depart();
  /// What was taken could not be made.
  void give_up();
  /// What was taken is to be made again: it is wanted as before, unless something newer is.
  void put_back();
  /// Nothing is wanted any more.
  void forget();
  /// Something is wanted; perhaps not to be taken just now.
  bool waiting() const;

 private:
  struct Sent {
    std::uint64_t seq = 0;
    std::uint32_t index = 0;
  };
  std::array<std::optional<std::uint32_t>, 3> wanted_;
  std::array<Sent, 3> sent_;  // the newest of each plane
  std::optional<SliceDue> making_;
  std::size_t turn_ = 0;
  std::uint64_t seq_ = 0;
  std::uint64_t taken_ = 0;
};

SliceStacks stacks_of(const volume::Header& header);
diaphane::v1::AnatomicalPlane to_proto(volume::Plane plane);
diaphane::v1::SliceStack to_proto(const volume::SliceStack& stack);

}  // namespace diaphane::render
