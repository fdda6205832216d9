#pragma once

#include <chrono>
#include <cstdint>
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
#include "renderd/session/slice_wishes.h"
#include "renderd/session/wanted.h"

namespace diaphane::render {

using TimePoint = std::chrono::steady_clock::time_point;

/// The id of the participant whose session it is; guests have ids of common/ids.h's form.
inline constexpr std::string_view kOwner = "owner";

/// A viewer that acknowledges nothing for so long gets no more device time until it does.
inline constexpr std::chrono::seconds kStalledAfter{15};
/// A presenter who acknowledges nothing for so long no longer sets the pace of the others.
inline constexpr std::chrono::seconds kPaceFor{1};
/// A connection that says no Hello within this time is ended: it holds a slot for nothing.
inline constexpr std::chrono::seconds kGreetingWithin{10};
/// The owner may take the presenter's role when the presenter has been away for so long: longer
/// than a reload of a page takes.
inline constexpr std::chrono::seconds kPresenterAway{5};
/// A stream whose frames build on each other: key frames asked for by those who missed something
/// come at most so often, because each costs as much as many others.
inline constexpr std::chrono::milliseconds kKeyEvery{500};
/// How far away something is may be asked so often: an answer takes milliseconds of a core.
inline constexpr std::chrono::milliseconds kDepthEvery{50};
inline constexpr std::chrono::milliseconds kKernelEvery{250};
inline constexpr std::size_t kMostReceivers = 64;
inline constexpr std::size_t kLongestName = 40;  ///< characters

/// One connection to a session, and what is on its way to it. Plain data.
struct Receiver {
  std::uint64_t connection = 0;
  std::string participant{kOwner};
  std::string name;
  std::string link;  ///< of a guest: which link let it in (worker.proto)
  ViewerKind viewer = ViewerKind::kGuest;
  bool may_have_slices = false;  ///< says the scan's owner, of visitors and of public scans

  bool greeted = false;  ///< its Hello was accepted
  bool visible = true;
  diaphane::v1::Codec codec = diaphane::v1::CODEC_UNSPECIFIED;
  std::shared_ptr<const diaphane::v1::Hello> hello;
  Canvas viewport{};               ///< that it has told; 0 x 0: none yet
  std::uint64_t newest_input = 0;  ///< of this connection
  TimePoint heard_at{};  ///< attached, last acknowledgement, or frame sent with none outstanding

  SliceWishes slices;                     ///< beside the pictures, and on a window of their own
  std::optional<TimePoint> depth_asked;   ///< last
  std::optional<TimePoint> kernel_asked;  ///< likewise
  bool kernel_wanted = false;             ///< and not answered yet
  bool has_clipped_slices = false;        ///< of the clip as it is

  FlightWindow flight;
  LinkEstimate path;  ///< what its connection carries
  QualitySteps quality;
  diaphane::v1::StillFormat stills = diaphane::v1::STILL_FORMAT_UNSPECIFIED;  ///< none: no lossless
  std::uint32_t tiles_sent = 0;    ///< of the lossless end of `shown`
  std::uint64_t sent_epoch = 0;    ///< of the newest frame sent
  std::optional<FrameInfo> shown;  ///< that frame
  std::uint64_t look_version = 0;  ///< Wanted::version of the newest scene told (Look, Config)
  bool converged_told = false;
  bool lossless_told = false;
  bool behind = false;      ///< it missed a picture, for want of room or of a key frame
  bool needs_key = true;    ///< of an inter-coded stream: it can decode nothing until a key frame
  bool own_camera = false;  ///< it looks at a session of its own; nothing of this one goes to it
};

/// One stream of coded pictures, for all whose codec it is.
struct Coding {
  std::vector<std::uint64_t> takers;  ///< connections for which a frame is being coded now
  std::optional<TimePoint> key_at;    ///< when the newest key frame was asked for
};

/// Who is connected to a session, and who presents. Plain data; rules in audience.cpp and
/// state.cpp.
struct Audience {
  std::vector<Receiver> receivers;              ///< in the order in which they came
  std::string presenter{kOwner};                ///< participant, here or not
  TimePoint presenter_left{};                   ///< when the presenter is not here
  std::uint64_t connections = 0;                ///< so far
  std::map<std::string, std::uint64_t> guests;  ///< participants with a number for a name
  std::map<diaphane::v1::Codec, Coding> codings;
  SliceAllowances slice_allowances;
  bool guest_slices = false;  ///< the host lets guests have slices

  Receiver* find(std::uint64_t connection);
  const Receiver* find(std::uint64_t connection) const;
  Receiver* of(std::string_view participant);
  const Receiver* of(std::string_view participant) const;
  bool presents(const Receiver& receiver) const { return receiver.participant == presenter; }
  Standing standing(const Receiver& receiver) const;
};

/// Frames of these build on those before: one that misses a frame waits for a key frame.
bool is_inter_coded(diaphane::v1::Codec codec);

/// A name as others may see it: valid UTF-8 without control, direction and invisible characters,
/// spaces single, at most kLongestName characters. May be empty.
std::string clean_name(std::string_view typed);

/// Another picture may leave for it: neither too many nor too many bytes are on their way.
bool has_room(const Receiver& receiver);

/// Greeted, its page is looked at, and it takes what is sent.
bool is_watching(const Receiver& receiver, TimePoint now);

/// The presenter's role is given or taken: who asks, and to whom. kForbidden, kNotFound.
Result<void> hand_over(Audience& audience, const Receiver& from, std::string_view to,
                       TimePoint now);

/// Who is here, as `receiver` is told.
diaphane::v1::Audience audience_for(const Audience& audience, const Receiver& receiver);

}  // namespace diaphane::render
