#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/proto/stream.pb.h"
#include "common/result.h"
#include "renderd/session/flight.h"
#include "renderd/session/quality.h"
#include "renderd/session/rights.h"
#include "renderd/session/slice_allowance.h"
#include "renderd/session/slice_request_queue.h"
#include "renderd/session/view_request.h"

namespace diaphane::render {

using TimePoint = std::chrono::steady_clock::time_point;

/// The id of the participant who owns the session. Guests have ids in the form of common/ids.h.
inline constexpr std::string_view kOwner = "owner";

/// A viewer who acknowledges nothing for this long gets no device time until they do.
inline constexpr std::chrono::seconds kStalledAfter{15};
/// A presenter who acknowledges nothing for this long no longer sets the pace of the others.
inline constexpr std::chrono::seconds kPaceFor{1};
/// A connection that sends no Hello within this time is closed, because it blocks a slot.
inline constexpr std::chrono::seconds kGreetingWithin{10};
/// Minimum time between key frames that viewers of an inter-coded stream request after a loss,
/// because each costs as much as many other frames.
inline constexpr std::chrono::milliseconds kKeyEvery{500};
/// Minimum time between depth queries, because an answer takes milliseconds of a core.
inline constexpr std::chrono::milliseconds kDepthEvery{50};
inline constexpr std::chrono::milliseconds kKernelEvery{250};
/// How long a guest may still request slices that the presenter has scrolled past, because the
/// request of a guest with a slow connection is on its way for a while.
inline constexpr std::chrono::seconds kShownBefore{2};
inline constexpr std::size_t kMostShownBefore = 32;
inline constexpr std::size_t kMostReceivers = 64;
inline constexpr std::size_t kLongestName = 40;  ///< characters

/// How much of the state that participants share (collaboration.h) was sent to a viewer.
struct SharedWindow {
  std::uint64_t sent = 0;           ///< sequence number
  std::uint64_t taken = 0;          ///< acknowledged
  std::uint64_t slices_seen = 0;    ///< version of what was sent of the presenter's slices
  std::uint64_t pointers_seen = 0;  ///< version of what was sent of the pointers
  std::uint64_t marks_seen = 0;     ///< version of what was sent of the marks
};

/// One connection to a session, and the messages in transit to it. Plain data.
struct Receiver {
  std::uint64_t connection = 0;
  std::string participant{kOwner};
  std::string name;
  std::uint32_t number = 0;  ///< the smallest number that is unique among the receivers
  std::string link;          ///< link by which a guest joined (worker.proto)
  ViewerKind viewer = ViewerKind::kGuest;
  bool may_have_slices = false;  ///< set by the owner of the scan, or by the link of a guest
  bool may_download = false;     ///< set by the owner of the scan

  bool greeted = false;  ///< whether its Hello was accepted
  bool visible = true;
  diaphane::v1::Codec codec = diaphane::v1::CODEC_UNSPECIFIED;
  std::shared_ptr<const diaphane::v1::Hello> hello;
  Canvas viewport{};               ///< size that the page reported; 0 x 0: none yet
  std::uint64_t newest_input = 0;  ///< newest input of this connection
  /// Time of attachment, of the last acknowledgement, or of a frame sent with none outstanding.
  TimePoint last_progress_at{};

  SliceRequestQueue slices;               ///< slice requests, with a window separate from that of
                                          ///< the pictures
  std::optional<TimePoint> depth_asked;   ///< time of the last query
  std::optional<TimePoint> kernel_asked;  ///< time of the last request
  std::optional<TimePoint> curve_asked;   ///< time of the last request of the error curve
  std::optional<TimePoint> good_views_asked;  ///< time of the last request
  bool kernel_wanted = false;                 ///< requested, but not answered yet
  bool has_slices = false;                    ///< whether it has slices of the current phase
  bool has_clipped_slices = false;            ///< whether it has slices of the current clip
  SharedWindow shared;
  std::uint64_t hand = 0;  ///< increases with each raised hand; 0: the hand is not raised

  FlightWindow flight;
  LinkEstimate path;  ///< estimated capacity of its connection
  QualitySteps quality;
  /// Format of the lossless tiles. Unspecified: the viewer gets none.
  diaphane::v1::StillFormat stills = diaphane::v1::STILL_FORMAT_UNSPECIFIED;
  std::uint32_t tiles_sent = 0;    ///< lossless tiles of `shown`
  std::uint64_t sent_epoch = 0;    ///< epoch of the newest frame sent
  std::optional<FrameInfo> shown;  ///< the newest frame sent
  std::uint64_t look_version = 0;  ///< ViewRequest::version of the newest scene sent (Look, Config)
  bool converged_sent = false;
  bool lossless_sent = false;
  bool behind = false;       ///< it missed a picture for lack of room or of a key frame
  bool needs_key = true;     ///< whether it needs a key frame before it can decode further frames
  bool free_camera = false;  ///< it sees a session of its own and receives nothing from this one
};

/// The slices that a presenter shows, or showed until `until`.
struct ShownSlices {
  diaphane::v1::SliceView::Layout layout = diaphane::v1::SliceView::LAYOUT_UNSPECIFIED;
  diaphane::v1::AnatomicalPlane plane = diaphane::v1::ANATOMICAL_PLANE_UNSPECIFIED;
  std::array<double, 3> crosshair{};
  TimePoint until{};
  /// Normals of oblique planes. Empty if the planes lie along the patient's axes.
  std::map<diaphane::v1::AnatomicalPlane, volume::Vector> normals;
  double slab = 0;  ///< mm
  volume::Projection projection = volume::Projection::kMean;

  bool contains(const volume::SliceStack& stack, const SliceDue& due) const;

 private:
  bool contains(const volume::SliceStack& stack, const volume::ObliqueSlice& slice) const;
};

/// One stream of encoded pictures for all viewers that use its codec.
struct Coding {
  std::vector<std::uint64_t> takers;  ///< connections for which a frame is being encoded
  std::optional<TimePoint> key_at;    ///< when the newest key frame was requested
};

/// The connections of a session, and its presenter. Plain data with rules in audience.cpp and
/// state.cpp.
struct Audience {
  std::vector<Receiver> receivers;  ///< in the order of arrival
  std::string presenter{kOwner};    ///< a participant, connected or not
  std::uint64_t connections = 0;    ///< total so far
  /// Numbers that replace missing names, by participant.
  std::map<std::string, std::uint64_t> guests;
  std::map<diaphane::v1::Codec, Coding> codings;
  SliceAllowances slice_allowances;
  bool guest_slices = false;  ///< the host allows slices for guests while the presenter shows some
  ShownSlices slices_shown;   ///< what the presenter shows now
  std::deque<ShownSlices> slices_before;  ///< what they showed just before
  bool guest_pointers = true;             ///< the presenter allows pointers and marks of guests
  std::uint64_t hands = 0;                ///< raised so far

  Receiver* find(std::uint64_t connection);
  const Receiver* find(std::uint64_t connection) const;
  Receiver* of(std::string_view participant);
  const Receiver* of(std::string_view participant) const;
  bool presents(const Receiver& receiver) const { return receiver.participant == presenter; }
  ViewerRights rights(const Receiver& receiver) const;
  /// Returns whether the presenter's slices are open.
  bool shows_slices() const {
    return slices_shown.layout != diaphane::v1::SliceView::LAYOUT_UNSPECIFIED;
  }
  /// Notes what the presenter shows.
  void show(const diaphane::v1::SliceView& view, TimePoint now);
  /// Returns whether the presenter shows this slice of a stack, or did so just before.
  bool shows(const volume::SliceStack& stack, const SliceDue& due, TimePoint now) const;
};

/// Returns whether frames depend on previous ones, so that a viewer who misses a frame must wait
/// for a key frame.
bool is_inter_coded(diaphane::v1::Codec codec);

/// Sanitises a name for display: valid UTF-8 without control, direction and invisible characters,
/// single spaces, and at most kLongestName characters. May be empty.
std::string clean_name(std::string_view typed);

/// Returns whether another picture may be sent: neither too many pictures nor too many bytes are in
/// transit.
bool has_room(const Receiver& receiver);

/// Returns whether the viewer has greeted, is visible, and acknowledges what is sent.
bool is_watching(const Receiver& receiver, TimePoint now);

/// Hands the presenter's role over on request of `from`: the presenter, or the owner, who may take
/// it back at any time. Fails with kForbidden for anyone else, with kNotFound if `to` is absent and
/// with kConflict if `to` uses a free camera.
Result<void> hand_over(Audience& audience, const Receiver& from, std::string_view to);

/// Returns the participants as `receiver` may see them.
diaphane::v1::Audience audience_for(const Audience& audience, const Receiver& receiver);

}  // namespace diaphane::render
