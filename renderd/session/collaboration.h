#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "renderd/math/vector.h"
#include "renderd/session/effects.h"
#include "renderd/session/state.h"

namespace diaphane::render {

struct SliceViewSent {
  std::uint64_t connection = 0;
  const diaphane::v1::SliceView& view;
};
struct MeasurementsSent {
  std::uint64_t connection = 0;
  const diaphane::v1::Measurements& measurements;
};
struct PointerMoved {
  std::uint64_t connection = 0;
  const diaphane::v1::PointerMove& move;
};
/// The surface at which a participant points. nullopt: only background is visible there.
struct PointerFound {
  std::uint64_t connection = 0;
  std::uint64_t number = 0;  ///< number in effect::FindPointer
  std::optional<Double3> place;
};
struct MarksSent {
  std::uint64_t connection = 0;
  const diaphane::v1::Marks& marks;
};
struct MarkSightRequested {
  std::uint64_t connection = 0;
};
struct SharedReceived {
  std::uint64_t connection = 0;
  std::uint64_t seq = 0;
};
/// Participants came, left or got other rights, or someone else presents.
struct ParticipantsChanged {};

/// What the participants of a session show each other: the presenter's slices and measurements, and
/// everyone's pointer and marks. Each viewer has at most kMostUnderWay messages in transit. What
/// changes meanwhile is sent as one message with the newest state, so that a slow connection never
/// has a queue. A session with one viewer sends nothing, and stores only marks.
///
/// Only viewers with access to slices receive what concerns slices. All viewers receive the places
/// of pointers in the picture. These reveal the visible surface, which every viewer may look at
/// from all sides with a camera of their own.
class Collaboration {
 public:
  static constexpr std::uint64_t kMostUnderWay = 2;
  /// Burst and rate of pointer moves per participant. Pages send ten moves per second.
  static constexpr double kMovesInARow = 20;
  static constexpr double kMovesASecond = 15;
  /// Burst and rate of moves in the picture per session. Each takes about a millisecond of a core.
  static constexpr double kSurfacesInARow = 40;
  static constexpr double kSurfacesASecond = 40;
  /// Burst and rate of changed marks per participant. Pages send ten per second during a drag.
  static constexpr double kMarksInARow = 20;
  static constexpr double kMarksASecond = 15;
  /// Burst and rate of mark sight queries per participant. Each may take some milliseconds of a
  /// core.
  static constexpr double kSightsInARow = 10;
  static constexpr double kSightsASecond = 5;
  /// A pointer that has not moved for this long is hidden.
  static constexpr std::chrono::seconds kPointerFor{4};

  Effects handle(const SliceViewSent& event, SessionState& state, TimePoint now);
  Effects handle(const MeasurementsSent& event, SessionState& state, TimePoint now);
  Effects handle(const PointerMoved& event, SessionState& state, TimePoint now);
  Effects handle(const PointerFound& event, SessionState& state, TimePoint now);
  Effects handle(const MarksSent& event, SessionState& state, TimePoint now);
  Effects handle(const MarkSightRequested& event, const SessionState& state, TimePoint now);
  Effects handle(const SharedReceived& event, SessionState& state, TimePoint now);
  Effects handle(ParticipantsChanged event, SessionState& state, TimePoint now);

  struct PlacedMark {
    std::uint32_t number = 0;  ///< Participant.number
    std::uint32_t id = 0;
    Double3 place;
  };
  /// Returns the marks that participants show, in an order that is the same for all viewers, so
  /// that viewers of the same picture can share an answer.
  std::vector<PlacedMark> placed_marks() const;

 private:
  struct Pointer {
    diaphane::v1::SharedState::Pointer shown;
    bool of_guest = false;
    std::uint64_t version = 0;
    std::uint64_t moves = 0;
    TimePoint moved_at{};
    Bucket allowance{kMovesInARow, kMovesASecond};
  };
  struct MarksOf {
    diaphane::v1::Marks marks;
    std::uint32_t number = 0;
    bool shown = true;  ///< false: the presenter has turned off the marks of guests
    std::uint64_t version = 0;
    Bucket allowance{kMarksInARow, kMarksASecond};
    Bucket sights{kSightsInARow, kSightsASecond};
  };
  template <typename Message>
  struct Versioned {
    Message message;
    std::uint64_t version = 0;
  };

  Effects moved(Pointer& pointer, SessionState& state, TimePoint now);
  Effects broadcast(SessionState& state, TimePoint now) const;
  /// Hides or shows the marks of guests according to the presenter's setting.
  void apply_permission(const Audience& audience);
  void add_marks(diaphane::v1::SharedState& shared, Receiver& receiver) const;
  void send_changes(Effects& effects, const SessionState& state, Receiver& receiver,
                    TimePoint now) const;
  /// Returns whether someone other than the sender would see a change.
  static bool is_shared(const SessionState& state);

  std::uint64_t version_ = 0;
  Versioned<diaphane::v1::SliceView> view_;
  Versioned<diaphane::v1::Measurements> measurements_;
  std::map<std::string, Pointer> pointers_;  // by participant
  std::map<std::string, MarksOf> marks_;     // by participant
  Bucket surfaces_{kSurfacesInARow, kSurfacesASecond};
};

}  // namespace diaphane::render
