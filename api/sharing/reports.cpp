#include "api/sharing/reports.h"

#include <utility>

#include "api/shared/secrets.h"
#include "common/ids.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

AuditEntry entry_of(const Principal& who, std::string action, std::string subject,
                    std::string subject_id) {
  AuditEntry entry;
  entry.actor = AuditActor::kAdministrator;
  entry.actor_id = who.user_id;
  entry.action = std::move(action);
  entry.subject = std::move(subject);
  entry.subject_id = std::move(subject_id);
  return entry;
}

}  // namespace

Reports::Reports(DataSets& data_sets, Presets& presets, ReportStore& store, AccountStore& accounts,
                 const Clock& clock, std::function<void(const std::string&)> end_lost_sessions)
    : data_sets_(data_sets),
      presets_(presets),
      store_(store),
      accounts_(accounts),
      clock_(clock),
      end_lost_sessions_(std::move(end_lost_sessions)) {}

Outcome<void> Reports::report(const Principal& who, const std::string& data_set_id,
                              const std::string& reason, const std::string& words) {
  const auto data_set = data_sets_.authorise(who, data_set_id, Action::kReport);
  DIAPHANE_TRY(data_set);
  return note(who, {{}, data_set_id, {}, {}, {}, reason, words, false, {}});
}

Outcome<void> Reports::report_preset(const Principal& who, const std::string& preset_id,
                                     const std::string& reason, const std::string& words) {
  const auto preset = presets_.find(who, preset_id);
  DIAPHANE_TRY(preset);
  if (preset->mine) {
    return refuse(ProblemKind::kForbidden,
                  "You can't report your own preset. Edit or delete it instead.");
  }
  DIAPHANE_TRY(data_sets_.authorise(who, preset->data_set_id, Action::kReport));
  return note(who, {{}, preset->data_set_id, {}, preset_id, {}, reason, words, false, {}});
}

Outcome<void> Reports::note(const Principal& who, Report report) {
  const auto now = clock_.wall();
  const auto wait =
      accounts_.note_attempt({{blake2b("report:" + who.user_id), 20, std::chrono::hours(24)}}, now);
  if (!wait) return refuse(wait.error());
  if (*wait) {
    return refuse(ProblemKind::kTooManyAttempts,
                  "You have reached today's report limit. Try again tomorrow.", **wait);
  }
  report.id = new_id();
  report.created_at = now;
  const auto done = store_.report(report, who.user_id);
  if (!done) return refuse(done.error());
  return {};
}

Outcome<std::vector<Report>> Reports::open(const Principal& who) {
  auto found = store_.open(200, entry_of(who, "reports.looked-at", "report", ""), clock_.wall());
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<int> Reports::count_open() {
  const auto counted = store_.count_open();
  if (!counted) return refuse(counted.error());
  return *counted;
}

Outcome<std::vector<TakeDown>> Reports::taken_down(const Principal& who) {
  auto found =
      store_.taken_down(200, entry_of(who, "reports.looked-at", "report", ""), clock_.wall());
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<void> Reports::close(const Principal& who, const std::string& report_id) {
  const auto none = [] { return refuse(ProblemKind::kNotFound, "Report not found."); };
  if (!is_id(report_id)) return none();
  const auto done = store_.close(report_id, entry_of(who, "report.dismissed", "report", report_id),
                                 clock_.wall());
  if (!done && done.error().code == ErrorCode::kNotFound) return none();
  if (!done) return refuse(done.error());
  return {};
}

Outcome<void> Reports::take_down(const Principal& who, const std::string& data_set_id,
                                 const std::string& reason) {
  const auto data_set = data_sets_.authorise(who, data_set_id, Action::kTakeDown);
  DIAPHANE_TRY(data_set);
  const auto done = store_.take_down(data_set_id, reason,
                                     entry_of(who, "data-set.taken-down", "data_set", data_set_id),
                                     clock_.wall());
  if (!done) return refuse(done.error());
  end_lost_sessions_(data_set_id);
  return {};
}

Outcome<void> Reports::restore(const Principal& who, const std::string& data_set_id) {
  const auto data_set = data_sets_.authorise(who, data_set_id, Action::kTakeDown);
  DIAPHANE_TRY(data_set);
  const auto done = store_.restore(
      data_set_id, entry_of(who, "data-set.restored", "data_set", data_set_id), clock_.wall());
  if (!done) return refuse(done.error());
  return {};
}

Outcome<void> Reports::may_judge(const Principal& who, const std::string& preset_id) {
  const auto preset = presets_.find(who, preset_id);
  DIAPHANE_TRY(preset);
  DIAPHANE_TRY(data_sets_.authorise(who, preset->data_set_id, Action::kTakeDown));
  return {};
}

Outcome<void> Reports::take_down_preset(const Principal& who, const std::string& preset_id,
                                        const std::string& reason) {
  if (auto may = may_judge(who, preset_id); !may) return may;
  const auto done = store_.take_down_preset(
      preset_id, reason, entry_of(who, "preset.taken-down", "preset", preset_id), clock_.wall());
  if (!done) return refuse(done.error());
  return {};
}

Outcome<void> Reports::restore_preset(const Principal& who, const std::string& preset_id) {
  if (auto may = may_judge(who, preset_id); !may) return may;
  const auto done = store_.restore_preset(
      preset_id, entry_of(who, "preset.restored", "preset", preset_id), clock_.wall());
  if (!done) return refuse(done.error());
  return {};
}

}  // namespace diaphane::api
