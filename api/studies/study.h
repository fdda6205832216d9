#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/shared/time.h"

/// Studies of perception, which researchers compose and people without an account take part in.
namespace diaphane::api {

enum class StudyState { kDraft, kOpen, kClosed };
std::string_view to_string(StudyState state);
/// Returns kClosed for an unknown text.
StudyState study_state_of(std::string_view text);

/// The content of a study, checked by study_format.h.
struct StudyContent {
  std::string definition;  ///< JSON
  std::string title;       ///< the definition's title, as JSON
  int places = 0;
  Time ends_at{};
};

struct Study {
  std::string id, owner_id;
  StudyContent content;  ///< without the definition in lists
  StudyState state = StudyState::kDraft;
  int version = 1;
  int joined = 0, finished = 0, withdrawn = 0;  ///< participants, without previews
  Time created_at{};
  std::optional<Time> opened_at, closed_at;
};

struct StudyPicture {
  std::string id;
  std::string type;  ///< "image/jpeg" or "image/png"
  std::string bytes;
};

struct StudyAnswer {
  std::string step;
  std::string value;  ///< JSON
  std::int64_t duration_ms = 0;
  std::int64_t sequence = 0;
};

struct Participant {
  std::string id;
  int number = 0;
  std::string key_hash;
  std::string language;  ///< "en" or "de"
  std::int64_t seed = 0;
  std::string day;  ///< "2026-11-28"
  bool recorded = false;
  bool finished = false;
  bool preview = false;
  std::string session_id;  ///< of their render session, or empty
};

/// A participant with the study that they take part in.
struct Participation {
  Participant participant;
  Study study;
  bool open = false;  ///< whether answers are accepted
};

/// Maximum number of pictures of a study.
inline constexpr std::size_t kMostStudyPictures = 20;

/// Maximum number of previews of a study, of which a new one replaces the oldest.
inline constexpr int kMostPreviews = 10;

/// The largest seed is below 2^53, so that a number of JavaScript holds it exactly.
inline constexpr std::int64_t kSeeds = std::int64_t{1} << 53;

}  // namespace diaphane::api
