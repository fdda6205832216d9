#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "api/accounts/account_store.h"
#include "api/scans/access.h"
#include "api/scans/view_log.h"
#include "api/shared/audit.h"
#include "api/shared/cursor.h"
#include "api/shared/idempotency.h"
#include "common/result.h"

namespace diaphane::api {

/// The owner of a data set: a user, or nobody (an empty ID) for a sample.
struct Owner {
  std::string user_id;
};

/// The requester of a list or lookup. A visitor without an account has only default values.
struct Viewer {
  std::string user_id;
  bool sample_operator = false;
  bool administrator = false;
};

/// The states of migrations/0002. The text is the same in the API and in the database.
enum class DataSetState { kUploading, kQueued, kBuilding, kReady, kRefused, kExpired };
std::string_view to_string(DataSetState state);
DataSetState data_set_state_of(std::string_view text);

/// The upload of a scan has the ID of its data set, but an upload of labels has its own ID.
struct Upload {
  std::string id;
  std::int64_t length = 0;    ///< bytes
  std::int64_t received = 0;  ///< bytes
  Time expires_at;
  DataSetState state = DataSetState::kUploading;
};

/// The state of a scan's labels, which only the owner sees.
struct LabelState {
  int count = 0;
  std::int64_t bytes = 0;
  bool placing = false;                    ///< ingestd is still processing a complete upload
  std::optional<Upload> upload;            ///< in progress
  std::string refusal_code, refusal_text;  ///< of the last upload; empty if accepted
};

/// What an owner allows viewers of a data set beyond its pictures.
struct Permissions {
  bool slices = false;     ///< exact slices
  bool downloads = false;  ///< videos and large pictures
};

struct DataSet {
  std::string id;
  std::string title;
  DataSetState state = DataSetState::kUploading;
  std::string description;
  std::string body_part;      ///< one of kBodyParts, or empty if unknown
  Role role = Role::kNobody;  ///< role of the requester
  bool is_public = false;     ///< also true for samples
  bool is_sample = false;
  Permissions to_public;    ///< of everyone while it is public
  Permissions to_person;    ///< of the requester, if it is shared with them
  bool taken_down = false;  ///< hidden by an administrator
  std::string taken_down_reason;
  std::string owner_name;     ///< chosen by the owner, or empty
  int people = 0, links = 0;  ///< number of people and links with access; visible to the owner
  std::optional<Time> published_at, anonymised_at;
  std::string refusal_code, refusal_text;  ///< set in state kRefused
  /// Visible to the owner in state kQueued: what the scan waits for in addition to its turn
  /// ("room", "memory" or "service"), or empty.
  std::string waiting_for;
  // The following members are set in state kReady.
  std::string modality;
  std::array<int, 3> size{};
  int phases = 1;
  std::array<double, 3> spacing{};  ///< mm
  std::int64_t volume_bytes = 0;
  std::vector<std::string> repairs;
  LabelState labels;             ///< only in state kReady, for the owner
  std::optional<Upload> upload;  ///< only in state kUploading, for the owner
  Time created_at;               ///< exact to the microsecond
  Time updated_at;

  bool owned() const { return role == Role::kOwner; }
  /// Returns what everyone with an account may get: slices and downloads of a sample, and what the
  /// owner of a public data set allows.
  Permissions allowed_to_public() const {
    if (is_sample) return {true, true};
    return is_public ? to_public : Permissions();
  }
  /// Returns what the requester may get.
  Permissions allowed() const {
    if (owned()) return {true, true};
    const Permissions everyone = allowed_to_public();
    return {everyone.slices || to_person.slices, everyone.downloads || to_person.downloads};
  }
  Exposure exposure() const {
    if (taken_down) return Exposure::kTakenDown;
    if (is_sample) return Exposure::kSample;
    return is_public ? Exposure::kPublic : Exposure::kPrivate;
  }
};

inline constexpr std::array<std::string_view, 10> kBodyParts{
    "head", "neck", "chest", "abdomen", "pelvis", "spine", "arm", "leg", "whole", "other"};
inline constexpr std::array<std::string_view, 4> kModalities{"CT", "MR", "PT", "OTHER"};

/// Changes to the description of a data set. Absent fields stay unchanged.
struct Description {
  std::optional<std::string> title, text, body_part;  ///< an empty `body_part` means none
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

/// Maximum number of data sets per account: unprocessed ones, and in total.
struct DataSetLimits {
  int unprocessed = 0;
  int all = 0;
};

struct TooManyDataSets {
  bool unprocessed = false;  ///< which limit was reached: `unprocessed` or `all`
};

/// Data that must be deleted from disk.
struct Disposal {
  /// kPictures are images of a volume that was replaced. kPreset is the thumbnail of a preset.
  enum class Kind {
    kUpload,
    kVolume,
    kPictures,
    kExport,
    kPreset,
    kEnvironment,
    kScanExport
  } kind = Kind::kUpload;
  std::string id;
};

/// Data sets, their uploads and pending deletions. Every function returns kUnavailable if the
/// database is unavailable. Each is one transaction. An Owner or Viewer finds only what they may
/// access.
class DataSetStore {
 public:
  virtual ~DataSetStore() = default;

  using Creation = std::variant<Created, OverQuota, TooManyDataSets, KeyReused>;
  virtual Result<Creation> create(const NewDataSet& data_set, const DataSetLimits& limits,
                                  const std::optional<IdempotencyKey>& key, Time now) = 0;
  /// Lists the viewer's data sets in any state, and shared ones and samples that are ready, newest
  /// first, starting after `after`. Also accepts pending invitations of the viewer's address.
  virtual Result<std::vector<DataSet>> list(const Viewer& viewer, std::optional<Cursor> after,
                                            int limit) = 0;
  /// Finds a data set that the viewer has a role for: one of `list`, a public one that is ready or,
  /// for an administrator, one that was taken down. Otherwise returns kNotFound.
  virtual Result<DataSet> find(const Viewer& viewer, const std::string& id) = 0;
  virtual Result<void> describe(const std::string& id, const Description& what, Time now) = 0;
  /// Deletes the owner's data set and queues its files for deletion. May return kNotFound.
  virtual Result<void> remove(const Owner& owner, const std::string& id, Time now) = 0;

  virtual Result<Upload> find_upload(const Owner& owner, const std::string& id) = 0;
  /// Advances an upload from `from` to `to` bytes. At the full length, queues the data set, or its
  /// labels, and notifies ingestd. Returns kConflict if it is no longer at `from`.
  virtual Result<void> advance_upload(const std::string& id, std::int64_t from, std::int64_t to,
                                      Time expires_at, Time now) = 0;
  /// Deletes the owner's incomplete upload, and its data set unless it is an upload of labels.
  /// Returns kNotFound, or kConflict if it is complete.
  virtual Result<void> cancel_upload(const Owner& owner, const std::string& id, Time now) = 0;
  /// Marks inactive uploads as expired, queues their files for deletion and returns their number.
  virtual Result<int> expire_uploads(Time now) = 0;

  /// Adds the entry to the audit log, unless there is an equal one after `not_since`.
  virtual Result<void> note_access(const AuditEntry& entry, Time not_since, Time now) = 0;

  /// Adds the view to the view log and, unless there is an equal entry of the last hour, to the
  /// audit log. `entry.subject_id` is the data set.
  virtual Result<void> note_view(const View& view, const AuditEntry& entry, Time now) = 0;
  virtual Result<std::vector<ViewEntry>> views(const std::string& id, const ViewQuery& query) = 0;
  /// Deletes entries of the view log after kViewLife.
  virtual Result<void> expire_views(Time now) = 0;

  virtual Result<std::vector<Disposal>> disposals(int limit) = 0;
  virtual Result<void> disposed(const Disposal& disposal) = 0;
};

}  // namespace diaphane::api
