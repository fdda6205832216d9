#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "api/proto/stream.pb.h"
#include "common/result.h"
#include "volume/oblique.h"
#include "volume/slices.h"

namespace diaphane::render {

using SliceStacks = std::array<volume::SliceStack, 3>;  ///< in the order of volume::kPlanes

/// A slice to send to one viewer.
struct SliceDue {
  std::size_t plane = 0;  ///< number in volume::kPlanes
  std::uint32_t index = 0;
  std::optional<volume::ObliqueSlice> oblique;  ///< nullopt: the slice of the stack

  bool operator==(const SliceDue&) const = default;
};

/// The slice requests of one viewer: at most the newest of each plane, so that a slow connection
/// never has a queue of them. Plain data and arithmetic.
class SliceRequestQueue {
 public:
  static constexpr std::uint64_t kUnderWay = 3;  ///< sent, but not yet acknowledged

  /// Replaces a viewer's requests. Fails with kInvalid, naming the field, and changes nothing if
  /// they do not fit the stacks or the volume.
  Result<void> replace(const diaphane::v1::SliceRequest& request, const SliceStacks& stacks,
                       const volume::Header& header);
  /// Returns whether a slice can be taken now.
  bool ready() const { return !preparing_ && waiting() && seq_ - taken_ < kUnderWay; }
  /// Returns the next slice to read and encode, in turn by plane. The next one can be taken after
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
  std::array<std::optional<SliceDue>, 3> requested_;
  std::array<Sent, 3> sent_;  // the newest of each plane
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
