#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "api/service/access.h"
#include "api/service/account_store.h"
#include "api/service/cursor.h"
#include "api/service/idempotency.h"
#include "common/result.h"

namespace diaphane::api {

/// Whose data set: a person's, or (empty) the sample's, which belongs to nobody.
struct Owner {
  std::string user_id;
};

/// Who asks, as far as a list or a look-up needs to know. Nobody: neither user nor operator.
struct Viewer {
  std::string user_id;
  bool sample_operator = false;
  bool administrator = false;
};

/// The states of migrations/0002. Text on the wire, and in the database, is the same.
enum class DataSetState { kUploading, kQueued, kBuilding, kReady, kRefused, kExpired };
std::string_view to_string(DataSetState state);
DataSetState data_set_state_of(std::string_view text);

/// An upload has the id of its data set.
struct Upload {
  std::string id;
  std::int64_t length = 0;    ///< bytes
  std::int64_t received = 0;  ///< bytes
  Time expires_at;
  DataSetState state = DataSetState::kUploading;
};

struct DataSet {
  std::string id;
  std::string title;
  DataSetState state = DataSetState::kUploading;
  std::string description;
  std::string body_part;      ///< one of kBodyParts, or empty: not said
  Role role = Role::kNobody;  ///< of the one who asked
  bool is_public = false;     ///< samples too
  bool is_sample = false;
  bool public_slices = false;  ///< while it is public, whoever looks may have exact slices
  bool taken_down = false;     ///< by an administrator
  std::string taken_down_reason;
  std::string owner_name;     ///< chosen by the owner, or empty
  int people = 0, links = 0;  ///< it is shared with; told to the owner
  std::optional<Time> published_at, anonymised_at;
  std::string refusal_code, refusal_text;  ///< state kRefused
  /// State kQueued, told to the owner: "room", "memory" or "service", which it waits for beyond its
  /// turn; or empty.
  std::string waiting_for;
  // State kReady:
  std::string modality;
  std::array<int, 3> size{};
  std::array<double, 3> spacing{};  ///< mm
  std::int64_t volume_bytes = 0;
  std::vector<std::string> repairs;
  std::optional<Upload> upload;  ///< state kUploading, and owned
  Time created_at;               ///< exact to the microsecond
  Time updated_at;

  bool owned() const { return role == Role::kOwner; }
  /// A sample is everybody's; of what a person made public it is that person who says.
  bool slices_for_everybody() const { return is_sample || (is_public && public_slices); }
  Exposure exposure() const {
    if (taken_down) return Exposure::kTakenDown;
    if (is_sample) return Exposure::kSample;
    return is_public ? Exposure::kPublic : Exposure::kPrivate;
  }
};

inline constexpr std::array<std::string_view, 10> kBodyParts{
    "head", "neck", "chest", "abdomen", "pelvis", "spine", "arm", "leg", "whole", "other"};
inline constexpr std::array<std::string_view, 4> kModalities{"CT", "MR", "PT", "OTHER"};

/// What an owner says of a data set; absent: stays.
struct Description {
  std::optional<std::string> title, text, body_part;  ///< `body_part` empty: none
};

struct NewDataSet {
  std::string id;
  Owner owner;
  std::string title;
  std::int64_t bytes = 0;
  Time expires_at;
};

struct OverQuota {
  Quota quota;
};

/// How many data sets an account may have: that are not processed yet, and in all.
struct DataSetLimits {
  int unprocessed = 0;
  int all = 0;
};

struct TooManyDataSets {
  bool unprocessed = false;  ///< which of the two limits
};

/// What is to be removed from disk.
struct Disposal {
  /// kPictures: what was made of a volume that has been replaced. kPreset: a preset's picture.
  enum class Kind { kUpload, kVolume, kPictures, kExport, kPreset } kind = Kind::kUpload;
  std::string id;
};

/// Data sets, their uploads and what is to be disposed of. Every function: kUnavailable when the
/// database is away. Each is one transaction; nothing of somebody else's is ever found.
class DataSetStore {
 public:
  virtual ~DataSetStore() = default;

  using Creation = std::variant<Created, OverQuota, TooManyDataSets, KeyReused>;
  virtual Result<Creation> create(const NewDataSet& data_set, const DataSetLimits& limits,
                                  const std::optional<IdempotencyKey>& key, Time now) = 0;
  /// Own ones in any state; those shared with the viewer and samples, when they are ready. Newest
  /// first, after `after`. Invitations that waited for the viewer's address become his.
  virtual Result<std::vector<DataSet>> list(const Viewer& viewer, std::optional<Cursor> after,
                                            int limit) = 0;
  /// Whatever the viewer is something to: one of `list`, a public one that is ready, to an
  /// administrator also one that was taken down; else kNotFound.
  virtual Result<DataSet> find(const Viewer& viewer, const std::string& id) = 0;
  virtual Result<void> describe(const std::string& id, const Description& what, Time now) = 0;
  /// Forgets an own one and notes its files for disposal; kNotFound.
  virtual Result<void> remove(const Owner& owner, const std::string& id, Time now) = 0;

  virtual Result<Upload> find_upload(const Owner& owner, const std::string& id) = 0;
  /// From `from` to `to` bytes; at the full length the data set is queued and ingestd notified.
  /// kConflict when it does not stand at `from` in state uploading any more.
  virtual Result<void> advance_upload(const std::string& id, std::int64_t from, std::int64_t to,
                                      Time expires_at, Time now) = 0;
  /// Forgets an own data set while it is uploading. kNotFound; kConflict when it is past that.
  virtual Result<void> cancel_upload(const Owner& owner, const std::string& id, Time now) = 0;
  /// Marks what was left for too long and notes its file for disposal; how many.
  virtual Result<int> expire_uploads(Time now) = 0;

  virtual Result<std::vector<Disposal>> disposals(int limit) = 0;
  virtual Result<void> disposed(const Disposal& disposal) = 0;
};

}  // namespace diaphane::api
