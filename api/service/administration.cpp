#include "api/service/administration.h"

#include "common/ids.h"
#include "common/log.h"

namespace diaphane::api {
namespace {

tl::unexpected<Problem> no_such_account() {
  return refuse(ProblemKind::kNotFound, "There is no such account.");
}

}  // namespace

Outcome<Administration::Users> Administration::users(const std::string& part,
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
  return page;
}

Outcome<UserRecord> Administration::user(const std::string& id) {
  if (!is_id(id)) return no_such_account();
  auto found = store_.user(id, clock_.wall());
  if (!found) return refuse(found.error());
  if (!*found) return no_such_account();
  return **std::move(found);
}

Outcome<UserRecord> Administration::change(const Principal& who, const std::string& id,
                                           const UserChange& change) {
  if (!is_id(id)) return no_such_account();
  if (change.disabled.value_or(false) && id == who.user_id) {
    return refuse(ProblemKind::kConflict, "You cannot switch your own account off.");
  }
  const auto done = store_.change(who.user_id, id, change, clock_.wall());
  if (!done) return refuse(done.error());
  if (!*done) return no_such_account();
  if (change.disabled.value_or(false) && !placement_.end_all_by(id)) {
    log::warning("pictures of a disabled account not ended", {{"user", id}});
  }
  return user(id);
}

Outcome<Administration::AuditPage> Administration::audit(AuditFilter filter) {
  const int limit = filter.limit++;
  auto found = store_.audit(filter);
  if (!found) return refuse(found.error());
  AuditPage page{*std::move(found), std::nullopt};
  if (static_cast<int>(page.items.size()) > limit) {
    page.items.pop_back();
    page.next = page.items.back().id;
  }
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
