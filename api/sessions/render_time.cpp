#include "api/sessions/render_time.h"

#include <array>
#include <ctime>
#include <set>

#include "common/log.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

std::string first_day(Time month) {
  constexpr std::array kMonths{"January",   "February", "March",    "April",
                               "May",       "June",     "July",     "August",
                               "September", "October",  "November", "December"};
  const std::time_t seconds = std::chrono::system_clock::to_time_t(month);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  return std::string("1 ") + kMonths.at(static_cast<std::size_t>(utc.tm_mon));
}

std::string duration_text(std::int64_t ms) {
  const std::int64_t minutes = ms / 60'000;
  if (minutes < 120) return std::to_string(minutes) + (minutes == 1 ? " minute" : " minutes");
  return std::to_string(minutes / 60) + " hours";
}

tl::unexpected<Problem> all_spent(const RenderAccount& account) {
  return refuse(ProblemKind::kRenderTimeSpent,
                "You have used all of your rendering time for this month (" +
                    duration_text(account.quota_ms) + "). It resets on " +
                    first_day(account.next_month) + ".");
}

}  // namespace

Outcome<RenderAccount> RenderTime::account(const std::string& user_id) {
  auto found = store_.account(user_id, clock_.wall());
  if (!found) return refuse(found.error());
  return *std::move(found);
}

Outcome<void> RenderTime::may_open(const Principal& who) {
  if (who.user_id.empty()) return {};
  const auto mine = account(who.user_id);
  DIAPHANE_TRY(mine);
  if (mine->spent()) return all_spent(*mine);
  return {};
}

Outcome<void> RenderTime::may_go_on(const Principal& who) {
  if (who.user_id.empty()) return {};
  const auto mine = account(who.user_id);
  DIAPHANE_TRY(mine);
  const bool over = mine->spent() && mine->warned_at && *mine->warned_at + kGrace <= clock_.wall();
  if (over) return all_spent(*mine);
  return {};
}

void RenderTime::poll() {
  const auto spent = spent_.take_render_time();
  if (!spent) return;
  const Time now = clock_.wall();
  std::set<std::string> over;
  if (!spent->empty()) {
    if (const auto rendering = store_.add(*spent, now, now - kGrace)) {
      over.insert(rendering->begin(), rendering->end());
    } else {
      // The time was collected but not recorded, which favours the user.
      log::warning("failed to record rendering time",
                   {{"accounts", static_cast<int>(spent->size())}});
    }
  }
  if (const auto resting = store_.warned(now, now - kGrace - kSearchWindow, now - kGrace)) {
    over.insert(resting->begin(), resting->end());
  }
  for (const std::string& user : over) {
    if (!placement_.end_all_by(user))
      log::warning("failed to end the sessions of an account over its quota");
  }
}

}  // namespace diaphane::api
