#include "api/administration/administration.h"

#include "common/ids.h"
#include "common/log.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

tl::unexpected<Problem> no_such_account() {
  return refuse(ProblemKind::kNotFound, "Account not found.");
}

/// Returns the number of entries on a page, for the details of the audit log.
template <typename Page>
std::int64_t count(const Page& page) {
  return static_cast<std::int64_t>(page.items.size());
}

}  // namespace

Outcome<void> Administration::record_view(const Principal& who, std::string action,
                                          std::string subject, std::string subject_id,
                                          std::vector<AuditDetail> details) {
  const auto done = store_.note({AuditActor::kAdministrator, who.user_id, std::move(action),
                                 std::move(subject), std::move(subject_id), std::move(details)},
                                clock_.wall());
  if (!done) return refuse(done.error());
  return {};
}

Outcome<Administration::Users> Administration::users(const Principal& who, const std::string& part,
                                                     std::optional<Cursor> after, int limit) {
  auto found = store_.users(part, after, limit + 1, clock_.wall());
  if (!found) return refuse(found.error());
  Users page{*std::move(found), std::nullopt};
  if (static_cast<int>(page.items.size()) > limit) {
    page.items.pop_back();
    const UserRecord& last = page.items.back();
    page.next = Cursor{
        std::chrono::duration_cast<std::chrono::microseconds>(last.created_at.time_since_epoch())
            .count(),
        last.id};
  }
  if (auto noted = record_view(who, "accounts.looked-at", "account", "", {{"items", count(page)}});
      !noted) {
    return tl::unexpected(noted.error());
  }
  return page;
}

Outcome<UserRecord> Administration::user(const Principal& who, const std::string& id) {
  auto found = find(id);
  if (!found) return found;
  if (auto noted = record_view(who, "account.looked-at", "account", id, {}); !noted) {
    return tl::unexpected(noted.error());
  }
  return found;
}

Outcome<UserRecord> Administration::find(const std::string& id) {
  if (!is_id(id)) return no_such_account();
  auto found = store_.user(id, clock_.wall());
  if (!found) return refuse(found.error());
  if (!*found) return no_such_account();
  return **std::move(found);
}

bool Administration::end_pictures(const std::string& id) {
  bool ended = placement_.end_all_by(id).has_value();
  const auto data_sets = store_.ready_data_sets(id);
  if (!data_sets) return false;
  for (const std::string& one : *data_sets) {
    ended = placement_.end_all_of(one).has_value() && ended;
  }
  return ended;
}

Outcome<UserRecord> Administration::change(const Principal& who, const std::string& id,
                                           const UserChange& change) {
  if (!is_id(id)) return no_such_account();
  if (change.disabled.value_or(false) && id == who.user_id) {
    return refuse(ProblemKind::kConflict, "You can't disable your own account.");
  }
  const auto done = store_.change(who.user_id, id, change, clock_.wall());
  if (!done) return refuse(done.error());
  if (!*done) return no_such_account();
  if (change.disabled.value_or(false) && !end_pictures(id)) {
    log::warning("failed to end a disabled account's sessions", {{"user", id}});
  }
  return find(id);
}

Outcome<Administration::AuditPage> Administration::audit(const Principal& who, AuditFilter filter) {
  const int limit = filter.limit++;
  auto found = store_.audit(filter);
  if (!found) return refuse(found.error());
  AuditPage page{*std::move(found), std::nullopt};
  if (static_cast<int>(page.items.size()) > limit) {
    page.items.pop_back();
    page.next = page.items.back().id;
  }
  std::vector<AuditDetail> details{{"items", count(page)}};
  if (!filter.account_id.empty()) details.emplace_back("account", filter.account_id);
  DIAPHANE_TRY(record_view(who, "audit-log.looked-at", "audit_log", "", std::move(details)));
  return page;
}

Outcome<Administration::Fleet> Administration::fleet() {
  auto workers = workers_.alive();
  if (!workers) return refuse(workers.error());
  const auto queue = store_.ingest_queue();
  if (!queue) return refuse(queue.error());
  return Fleet{*std::move(workers), *queue};
}

}  // namespace diaphane::api
