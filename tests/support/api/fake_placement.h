#pragma once

#include <map>
#include <string>
#include <vector>

#include "api/shared/placement.h"
#include "common/try.h"
#include "tests/support/api/fake.h"

namespace diaphane::api {

/// The session directory in memory, for tests.
class FakePlacement final : public Placement, public Fake {
 public:
  std::map<std::string, SessionInfo> sessions;  ///< by ID
  std::vector<PlaceRequest> requests;
  /// Everything that was ended: IDs of sessions, "of <data set>", "by <user>" and
  /// "from <browser> of <user>".
  std::vector<std::string> ended;
  bool is_reachable = true;

  void add_session(const std::string& id, const std::string& user_id,
                   const std::string& data_set_id) {
    sessions[id] = {id, user_id, data_set_id, "worker"};
  }

  Result<Placed> place(const PlaceRequest& request) override {
    DIAPHANE_TRY(enter("place"));
    requests.push_back(request);
    // The second scan stays, as Redis keeps it.
    const auto known = sessions.find(request.session_id);
    const std::string over = known == sessions.end() ? request.over : known->second.over;
    add_session(request.session_id, request.user_id, request.data_set_id);
    sessions[request.session_id].charged_to = request.charged_to;
    sessions[request.session_id].over = over;
    return Placed{"ticket" + std::to_string(requests.size()), "worker", 1};
  }
  Result<SessionInfo> find(std::string_view id) override {
    DIAPHANE_TRY(enter("find"));
    const auto found = sessions.find(std::string(id));
    if (found == sessions.end()) return fail(ErrorCode::kNotFound, "no session");
    return found->second;
  }
  Result<std::vector<SessionInfo>> sessions_of(std::string_view user_id) override {
    DIAPHANE_TRY(enter("sessions_of"));
    return sessions_with([&](const SessionInfo& one) { return one.user_id == user_id; });
  }
  Result<std::vector<SessionInfo>> sessions_on(std::string_view data_set_id) override {
    DIAPHANE_TRY(enter("sessions_on"));
    return sessions_with([&](const SessionInfo& one) {
      return one.data_set_id == data_set_id || one.over == data_set_id;
    });
  }
  Result<void> end(std::string_view id) override {
    DIAPHANE_TRY(enter("end"));
    sessions.erase(std::string(id));
    ended.emplace_back(id);
    return {};
  }
  Result<void> end_all_of(std::string_view data_set_id) override {
    DIAPHANE_TRY(enter("end_all_of"));
    ended.push_back("of " + std::string(data_set_id));
    return {};
  }
  Result<void> end_all_by(std::string_view user_id) override {
    DIAPHANE_TRY(enter("end_all_by"));
    ended.push_back("by " + std::string(user_id));
    return {};
  }
  Result<void> end_all_from(std::string_view browser_id, std::string_view user_id) override {
    DIAPHANE_TRY(enter("end_all_from"));
    ended.push_back("from " + std::string(browser_id) + " of " + std::string(user_id));
    return {};
  }
  Result<void> refused(std::string_view, std::string_view, std::uint64_t) override { return {}; }
  bool reachable() override { return is_reachable; }

 private:
  template <typename Matches>
  std::vector<SessionInfo> sessions_with(const Matches& matches) const {
    std::vector<SessionInfo> found;
    for (const auto& [id, session] : sessions) {
      if (matches(session)) found.push_back(session);
    }
    return found;
  }
};

}  // namespace diaphane::api
