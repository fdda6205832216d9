#pragma once

#include <memory>
#include <optional>
#include <string>

#include "renderd/session/effects.h"
#include "renderd/session/events.h"
#include "renderd/session/state.h"

namespace diaphane::render {

/// The volume whose slices can be requested is loaded.
struct SlicesKnown {
  SliceStacks stacks;
  volume::Header header;
};
struct SlicesRequested {
  std::uint64_t connection = 0;
  const diaphane::v1::SliceRequest& request;
};
struct VoxelsLoaded {
  Result<std::shared_ptr<const DeviceVolume>> loaded;
  std::string shown_hash;  ///< content hash of the volume that the session shows
};
struct SliceCoded {
  std::uint64_t connection = 0;
  SliceOrder order;
  Result<std::string> coded;
  std::string second = {};  ///< of the second scan; empty: none
  std::string labels = {};  ///< of the pixels; empty: none
};
/// The labels of the volume in the store were replaced.
struct LabelsReplaced {};
/// Time has passed, so that requests over their limit may be due.
struct SlicesTicked {};
struct AllViewersLeft {};

/// The exact slices of a session beside its picture (docs/adr/0026). The first request loads the
/// voxels, and slices are made one by one for each viewer.
class Slices {
 public:
  Effects handle(const SlicesKnown& event);
  Effects handle(const SlicesRequested& event, SessionState& state, TimePoint now);
  Effects handle(const VoxelsLoaded& event, SessionState& state, TimePoint now);
  Effects handle(SliceCoded event, SessionState& state, TimePoint now);
  Effects handle(SlicesTicked event, SessionState& state, TimePoint now);
  Effects handle(SceneChanged event, SessionState& state, TimePoint now);
  Effects handle(LabelsReplaced event, SessionState& state);
  Effects handle(AllViewersLeft event);

  /// Returns nullopt until the volume is loaded.
  const std::optional<SliceStacks>& stacks() const { return stacks_; }

 private:
  void take_next(Effects& effects, SessionState& state, std::uint64_t connection,
                 TimePoint now) const;

  std::uint32_t phase_of(const SessionState& state) const;
  bool other_phase(const SessionState& state, TimePoint now);

  std::optional<SliceStacks> stacks_;
  volume::Header header_;    // of the volume that the stacks belong to
  std::uint32_t phase_ = 0;  ///< of the slices that viewers have, apart from stale ones
  std::uint32_t newest_phase_ = 0;
  TimePoint phase_changed_{};  ///< when `newest_phase_` changed
  // Kept while a viewer who requested slices is connected.
  std::shared_ptr<const HostVolume> voxels_;
  bool loading_ = false;
  std::shared_ptr<const diaphane::v1::Scene> clipped_by_;  // the scene whose clip applies
};

}  // namespace diaphane::render
