#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "api/proto/stream.pb.h"
#include "common/result.h"
#include "volume/curved_slice.h"
#include "volume/oblique.h"
#include "volume/slices.h"

namespace diaphane::render {

using SliceStacks = std::array<volume::SliceStack, 3>;  ///< in the order of volume::kPlanes

/// A slice to send to one viewer.
struct SliceDue {
  std::size_t plane = 0;  ///< number in volume::kPlanes; 0 for a curved slice
  std::uint32_t index = 0;
  std::optional<volume::ObliqueSlice> oblique;
  std::optional<volume::CurvedSlice> curved;  ///< nullopt for both: the slice of the stack

  /// Returns the number of samples of an oblique or curved slice, or 0 for one of the stack.
  std::uint64_t samples(const volume::Header& header) const;
  /// Returns the place in a viewer's requests, of which there is one per plane and one curved.
  std::size_t slot() const { return curved ? volume::kPlanes.size() : plane; }

  bool operator==(const SliceDue&) const = default;
};

/// The slice requests of one viewer: at most the newest of each plane and of the curve, so that a
/// slow connection never has a queue of them. Plain data and arithmetic.
class SliceRequestQueue {
 public:
  static constexpr std::uint64_t kUnderWay = 3;  ///< sent, but not yet acknowledged

  /// Replaces a viewer's requests. Fails with kInvalid, naming the field, and changes nothing if
  /// they do not fit the stacks or the volume.
  Result<void> replace(const diaphane::v1::SliceRequest& request, const SliceStacks& stacks,
                       const volume::Header& header);
  /// Returns whether a slice can be taken now.
  bool ready() const { return !preparing_ && waiting() && seq_ - taken_ < kUnderWay; }
  /// Returns the next slice to read and encode, in turn by slot. The next one can be taken after
  /// this one was sent or given up.
  std::optional<SliceDue> take();
  /// Marks the taken slice as sent. Returns its sequence number, from 1.
  std::uint64_t depart();
  /// Gives up the taken slice, which could not be made.
  void give_up();
  /// Requests the taken slice again, unless a newer request exists.
  void put_back();
  /// Drops all requests.
  void forget();
  /// Returns whether there is a request, even if it cannot be taken now.
  bool waiting() const;

 private:
  struct Sent {
    std::uint64_t seq = 0;
    SliceDue due;
  };
  static constexpr std::size_t kSlots = volume::kPlanes.size() + 1;
  std::array<std::optional<SliceDue>, kSlots> requested_;  // by SliceDue::slot()
  std::array<Sent, kSlots> sent_;                          // the newest of each
  std::optional<SliceDue> preparing_;
  std::size_t turn_ = 0;
  std::uint64_t seq_ = 0;
  std::uint64_t taken_ = 0;
};

SliceStacks stacks_of(const volume::Header& header);
diaphane::v1::AnatomicalPlane to_proto(volume::Plane plane);
volume::Projection projection_of(diaphane::v1::Projection projection);
diaphane::v1::SliceStack to_proto(const volume::SliceStack& stack);

}  // namespace diaphane::render
