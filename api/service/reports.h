#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "api/service/audit.h"
#include "api/service/data_sets.h"
#include "api/service/presets.h"
#include "common/clock.h"

namespace diaphane::api {

/// It shows who it is; it is somebody else's scan; it offends; something else.
inline constexpr std::array<std::string_view, 4> kReportReasons{"identifies", "not_theirs",
                                                                "offensive", "other"};

struct Report {
  std::string id;
  std::string data_set_id, title;
  std::string preset_id, preset_name;  ///< what it is about; empty: the data set itself
  std::string reason;                  ///< one of kReportReasons
  std::string words;                   ///< of the one who reports, or empty
  bool taken_down = false;             ///< what it is about
  Time created_at;
};

/// Implemented by postgres/report_repository. Every function: kUnavailable. Each is one
/// transaction, its audit entry in it.
class ReportStore {
 public:
  virtual ~ReportStore() = default;
  /// A second open one of the same person replaces what the first said.
  virtual Result<void> report(const Report& report, const std::string& reporter_id) = 0;
  /// Those that nobody has dealt with, oldest first.
  virtual Result<std::vector<Report>> open(int limit, const AuditEntry& entry, Time now) = 0;
  /// kNotFound.
  virtual Result<void> close(const std::string& report_id, const AuditEntry& entry, Time now) = 0;
  /// Private, shared with nobody, no links; closes its reports.
  virtual Result<void> take_down(const std::string& data_set_id, const std::string& reason,
                                 const AuditEntry& entry, Time now) = 0;
  /// Lifts it: private, to be published anew by its owner; a sample is public again.
  virtual Result<void> restore(const std::string& data_set_id, const AuditEntry& entry,
                               Time now) = 0;
  /// For its author and administrators alone, nobody's default; closes its reports. kNotFound.
  virtual Result<void> take_down_preset(const std::string& preset_id, const std::string& reason,
                                        const AuditEntry& entry, Time now) = 0;
  virtual Result<void> restore_preset(const std::string& preset_id, const AuditEntry& entry,
                                      Time now) = 0;
};

/// Reports of abuse and what an administrator does about them. Thread-safe.
class Reports {
 public:
  Reports(DataSets& data_sets, Presets& presets, ReportStore& store, AccountStore& accounts,
          const Clock& clock, std::function<void(const std::string&)> end_lost_sessions);

  /// At most 20 of a person in a day, of presets among them.
  Outcome<void> report(const Principal& who, const std::string& data_set_id,
                       const std::string& reason, const std::string& words);
  /// Somebody else's preset of what may be reported: its name offends.
  Outcome<void> report_preset(const Principal& who, const std::string& preset_id,
                              const std::string& reason, const std::string& words);
  /// That they were looked at is in the audit log.
  Outcome<std::vector<Report>> open(const Principal& who);
  Outcome<void> close(const Principal& who, const std::string& report_id);
  Outcome<void> take_down(const Principal& who, const std::string& data_set_id,
                          const std::string& reason);
  Outcome<void> restore(const Principal& who, const std::string& data_set_id);
  /// Both kNotFound for a preset of what is none of an administrator's business.
  Outcome<void> take_down_preset(const Principal& who, const std::string& preset_id,
                                 const std::string& reason);
  Outcome<void> restore_preset(const Principal& who, const std::string& preset_id);

 private:
  Outcome<void> note(const Principal& who, Report report);
  /// That an administrator may judge it.
  Outcome<void> may_judge(const Principal& who, const std::string& preset_id);

  DataSets& data_sets_;
  Presets& presets_;
  ReportStore& store_;
  AccountStore& accounts_;
  const Clock& clock_;
  std::function<void(const std::string&)> end_lost_sessions_;
};

}  // namespace diaphane::api
