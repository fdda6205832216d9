#include "directory/sessions.h"

#include <charconv>
#include <cstdlib>

#include "common/ids.h"
#include "directory/constants.h"
#include "directory/lists.h"

namespace diaphane::directory {
namespace {

constexpr std::size_t kTicketDigits = 64;

template <typename Number>
Number number(std::string_view text) {
  Number value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

bool is_ticket(std::string_view text) {
  return text.size() == kTicketDigits &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

tl::unexpected<Error> no_session() { return fail(ErrorCode::kNotFound, "Session not found."); }

tl::unexpected<Error> unexpected_answer() {
  return fail(ErrorCode::kInternal, "A session script returned an unexpected reply.");
}

/// Explains why a session was not placed.
tl::unexpected<Error> not_placed(const std::string& what) {
  if (what == "not_yours") return no_session();
  if (what == "signed_out") {
    return fail(ErrorCode::kUnauthenticated,
                "You have been signed out in this browser. Sign in again.");
  }
  if (what == "too_many") {
    return fail(ErrorCode::kTooMany,
                "You have reached the maximum number of open sessions. Close one, or try again in "
                "a moment.");
  }
  if (what == "full") {
    return fail(ErrorCode::kUnavailable,
                "All render slots are in use. Please try again in a moment.");
  }
  if (what == "visitors") {
    return fail(ErrorCode::kTooLarge, "All guest places are taken.");
  }
  if (what == "no_memory") {
    return fail(
        ErrorCode::kUnavailable,
        "No renderer has enough memory for this scan right now. Please try again in a moment.");
  }
  if (what == "no_worker") {
    return fail(ErrorCode::kUnavailable, "No renderer is running. Please try again in a moment.");
  }
  return unexpected_answer();
}

}  // namespace

Result<Placed> Sessions::place(const PlaceRequest& request) {
  if (!is_id(request.session_id) || !is_id(request.user_id) || !is_id(request.data_set_id) ||
      (!request.over.empty() && !is_id(request.over))) {
    return no_session();
  }
  const std::string epoch = std::to_string(kProtocolEpoch);
  const std::string ticket = random_hex(kTicketDigits / 2);
  const std::string reservation = std::to_string(limits_.reservation_ms);
  const std::string ticket_s = std::to_string(limits_.ticket_s);
  const std::string session_s = std::to_string(limits_.session_s);
  const std::string placed = std::to_string(limits_.placed);
  const std::string remembered = std::to_string(limits_.remembered);
  const std::string percent = std::to_string(limits_.visitor_percent);
  const Result<Reply> reply = client_.run(kPlace, {request.session_id,
                                                   request.user_id,
                                                   request.data_set_id,
                                                   ticket,
                                                   epoch,
                                                   reservation,
                                                   ticket_s,
                                                   session_s,
                                                   placed,
                                                   remembered,
                                                   request.participant,
                                                   request.name,
                                                   request.link,
                                                   request.first_scene,
                                                   fleet_,
                                                   request.browser,
                                                   to_string(request.viewer),
                                                   request.slices ? "1" : "0",
                                                   request.visitor ? "1" : "",
                                                   percent,
                                                   request.visitor_from,
                                                   request.downloads ? "1" : "0",
                                                   request.charged_to,
                                                   request.over,
                                                   request.to_first});
  if (!reply) return tl::unexpected(reply.error());
  const std::string& what = reply->at(0);
  if (what == "placed") {
    return Placed{ticket, reply->at(1), number<std::uint64_t>(reply->at(2))};
  }
  return not_placed(what);
}

Result<SessionInfo> Sessions::find(std::string_view session_id) {
  if (!is_id(session_id)) return no_session();
  const std::string key = "diaphane:session:" + std::string(session_id);
  const Result<Reply> reply =
      client_.command({"HMGET", key, "user", "data_set", "worker", "charged_to", "over"});
  if (!reply) return tl::unexpected(reply.error());
  if (reply->at(0).empty()) return no_session();
  return SessionInfo{std::string(session_id),
                     reply->at(0),
                     reply->at(1),
                     reply->at(2),
                     reply->at(3),
                     reply->at(4)};
}

Result<std::vector<SessionInfo>> Sessions::sessions_of(std::string_view user_id) {
  return list("user", user_id);
}

Result<std::vector<SessionInfo>> Sessions::sessions_on(std::string_view data_set_id) {
  return list("data_set", data_set_id);
}

Result<std::vector<SessionInfo>> Sessions::list(std::string_view of, std::string_view id) {
  std::vector<SessionInfo> sessions;
  if (!is_id(id)) return sessions;
  const Result<Reply> reply = client_.run(kListSessions, {of, id});
  if (!reply) return tl::unexpected(reply.error());
  for (const Reply& one : reply->list) {
    sessions.push_back({one.at(0), one.at(1), one.at(2), one.at(3), one.at(4), one.at(5)});
  }
  return sessions;
}

Result<void> Sessions::end(std::string_view session_id) {
  if (!is_id(session_id)) return {};
  const Result<Reply> reply = client_.run(kEndSessions, {"session", session_id});
  if (!reply) return tl::unexpected(reply.error());
  return {};
}

Result<void> Sessions::end_all_of(std::string_view data_set_id) {
  if (!is_id(data_set_id)) return {};
  const Result<Reply> reply = client_.run(kEndSessions, {"data_set", data_set_id});
  if (!reply) return tl::unexpected(reply.error());
  return {};
}

Result<void> Sessions::end_all_by(std::string_view user_id) {
  if (!is_id(user_id)) return {};
  const Result<Reply> reply = client_.run(kEndSessions, {"user", user_id});
  if (!reply) return tl::unexpected(reply.error());
  return {};
}

Result<void> Sessions::end_all_from(std::string_view browser_id, std::string_view user_id) {
  if (!is_id(browser_id) || !is_id(user_id)) return {};
  const Result<Reply> reply = client_.run(kEndSessions, {"browser", browser_id, user_id});
  if (!reply) return tl::unexpected(reply.error());
  return {};
}

Result<void> Sessions::refused(std::string_view session_id, std::string_view worker_id,
                               std::uint64_t placement) {
  const std::string which = std::to_string(placement);
  const std::string refused_ms = std::to_string(limits_.refused_ms);
  const Result<Reply> reply =
      client_.run(kSessionRefused, {session_id, worker_id, which, refused_ms});
  if (!reply) return tl::unexpected(reply.error());
  return {};
}

bool Sessions::reachable() { return client_.answers(std::chrono::milliseconds(80)); }

Result<Attachment> Sessions::consume(std::string_view ticket) {
  if (!is_ticket(ticket)) {
    return fail(ErrorCode::kUnauthenticated, "The ticket is unknown, already used or expired.");
  }
  const std::string reservation = std::to_string(limits_.reservation_ms);
  const std::string session_s = std::to_string(limits_.session_s);
  const Result<Reply> reply = client_.run(kConsumeTicket, {ticket, reservation, session_s});
  if (!reply) return tl::unexpected(reply.error());
  const std::string& what = reply->at(0);
  if (what == "attach") {
    Attachment found;
    found.session = {reply->at(1), reply->at(2), reply->at(3), reply->at(4)};
    found.address = reply->at(5);
    found.incarnation = reply->at(6);
    found.placement = number<std::uint64_t>(reply->at(7));
    found.scene = reply->at(8);
    found.input_seq = number<std::uint64_t>(reply->at(9));
    found.width = number<std::uint32_t>(reply->at(10));
    found.height = number<std::uint32_t>(reply->at(11));
    found.presenter = reply->at(12);
    found.participant = reply->at(13);
    found.name = reply->at(14);
    found.link = reply->at(15);
    found.viewer = session_viewer_of(reply->at(16));
    found.slices = reply->at(17) == "1";
    found.guest_slices = reply->at(18) == "1";
    found.visitor = reply->at(19) == "1";
    found.downloads = reply->at(20) == "1";
    found.session.over = reply->at(21);
    found.to_first = reply->at(22);
    return found;
  }
  if (what == "unknown") {
    return fail(ErrorCode::kUnauthenticated, "The ticket is unknown, already used or expired.");
  }
  if (what == "gone") return no_session();
  if (what == "worker_lost") {
    return fail(ErrorCode::kUnavailable,
                "The renderer of this session is gone. Request a new ticket.");
  }
  return unexpected_answer();
}

Result<std::vector<std::string>> Sessions::ended_links(const std::vector<std::string>& links) {
  std::vector<std::string> ended;
  if (links.empty()) return ended;
  const Result<Reply> reply = client_.run(kEndedLinks, {links.begin(), links.end()});
  if (!reply) return tl::unexpected(reply.error());
  for (const Reply& one : reply->list) ended.push_back(one.text);
  return ended;
}

Result<std::vector<WorkerInfo>> Sessions::alive() {
  const Result<Reply> reply = client_.run(kListWorkers, {std::to_string(kProtocolEpoch)});
  if (!reply) return tl::unexpected(reply.error());
  std::vector<WorkerInfo> workers;
  for (const Reply& one : reply->list) {
    workers.push_back({one.at(0), one.at(1), one.at(2), number<std::uint32_t>(one.at(3)),
                       number<std::uint32_t>(one.at(4)), one.at(5) == "1", split(one.at(6)),
                       one.at(7), one.at(8), std::strtod(one.at(9).c_str(), nullptr)});
  }
  return workers;
}

Result<std::vector<std::pair<std::string, std::int64_t>>> Sessions::take_render_time() {
  const Result<Reply> reply = client_.run(kTakeRenderTime, {});
  if (!reply) return tl::unexpected(reply.error());
  std::vector<std::pair<std::string, std::int64_t>> spent;
  for (std::size_t i = 0; i + 1 < reply->list.size(); i += 2) {
    const std::string& user = reply->list[i].text;
    const auto ms = number<std::int64_t>(reply->list[i + 1].text);
    if (is_id(user) && ms > 0) spent.emplace_back(user, ms);
  }
  return spent;
}

Result<bool> Sessions::lost(std::string_view worker_id, std::string_view incarnation) {
  const Result<Reply> reply = client_.run(kWorkerLost, {worker_id, incarnation});
  if (!reply) return tl::unexpected(reply.error());
  return reply->integer == 1;
}

}  // namespace diaphane::directory
