#include "directory/links.h"

#include "common/ids.h"

namespace diaphane::directory {
namespace {

tl::unexpected<Error> no_link() { return fail(ErrorCode::kNotFound, "Link not found."); }

}  // namespace

Result<void> Links::make(std::string_view session_id, std::string_view user_id,
                         std::string_view hash, bool slices) {
  const std::string life = std::to_string(limits_.life_s);
  const std::string most = std::to_string(limits_.per_session);
  const Result<Reply> reply =
      client_.run(kMakeLink, {session_id, user_id, hash, life, most, slices ? "1" : ""});
  if (!reply) return tl::unexpected(reply.error());
  if (reply->text == "made") return {};
  if (reply->text == "ended") return fail(ErrorCode::kConflict, "This link has been disabled.");
  if (reply->text == "other") {
    return fail(ErrorCode::kInvalid, "This link exists with other permissions.", "slices");
  }
  if (reply->text == "too_many") {
    return fail(ErrorCode::kTooMany,
                "This session has reached its link limit. Disable its links first.");
  }
  return fail(ErrorCode::kNotFound, "Session not found.");
}

Result<LinkStore::Target> Links::follow(std::string_view hash) {
  const Result<Reply> link = client_.command({"GET", "diaphane:link:" + std::string(hash)});
  if (!link) return tl::unexpected(link.error());
  const std::string id = link->text.substr(0, link->text.find(' '));
  if (!is_id(id)) return no_link();
  const Result<Reply> session =
      client_.command({"HMGET", "diaphane:session:" + id, "user", "data_set", "worker", "over"});
  if (!session) return tl::unexpected(session.error());
  if (session->at(0).empty()) return no_link();
  return Target{{id, session->at(0), session->at(1), session->at(2), "", session->at(3)},
                link->text != id};
}

Result<void> Links::end_links(std::string_view session_id) {
  const Result<Reply> reply = client_.run(kEndLinks, {session_id});
  if (!reply) return tl::unexpected(reply.error());
  return {};
}

}  // namespace diaphane::directory
