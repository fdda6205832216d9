#include "directory/worker.h"

#include <cstdio>
#include <cstdlib>

#include "directory/lists.h"

namespace diaphane::directory {
namespace {

std::string decimal(const char* format, double value) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string flag(bool value) { return value ? "1" : "0"; }

Arguments views(const std::vector<std::string>& arguments) {
  return {arguments.begin(), arguments.end()};
}

std::vector<std::string> texts(const Reply& list) {
  std::vector<std::string> all;
  for (const Reply& one : list.list) all.push_back(one.text);
  return all;
}

void append(std::vector<std::string>& arguments, const SavedScene& saved) {
  arguments.insert(arguments.end(),
                   {std::to_string(saved.placement), saved.scene, std::to_string(saved.input_seq),
                    std::to_string(saved.width), std::to_string(saved.height), saved.presenter,
                    flag(saved.guest_slices)});
}

}  // namespace

Result<HeartbeatReply> WorkerDirectory::beat(const Heartbeat& heartbeat) {
  std::vector<std::string> arguments{id_,
                                     incarnation_,
                                     heartbeat.address,
                                     heartbeat.engine,
                                     heartbeat.device,
                                     std::to_string(heartbeat.slots),
                                     flag(heartbeat.draining),
                                     decimal("%.3f", heartbeat.load),
                                     decimal("%.4f", heartbeat.expected),
                                     joined(heartbeat.volumes),
                                     heartbeat.node};
  for (const Heartbeat::Session& one : heartbeat.sessions) {
    arguments.insert(arguments.end(), {one.id, std::to_string(one.placement), flag(one.visitor)});
  }
  const Result<Reply> reply = client_.run(kHeartbeat, views(arguments));
  if (!reply) return tl::unexpected(reply.error());
  HeartbeatReply result;
  if (reply->at(0) == "name_taken") {
    result.name_taken_by = reply->at(1);
    return result;
  }
  if (reply->at(0) != "beat" || reply->list.size() != 3) {
    return fail(ErrorCode::kInternal, "heartbeat.lua returned an unexpected reply.");
  }
  result.ended = texts(reply->list[1]);
  result.unknown = texts(reply->list[2]);
  return result;
}

Result<void> WorkerDirectory::leave() {
  const Result<Reply> reply = client_.run(kDeregister, {id_, incarnation_});
  if (!reply) return tl::unexpected(reply.error());
  return {};
}

Result<std::optional<std::size_t>> WorkerDirectory::report(const FleetReport& report) {
  const std::string memory = decimal("%.3f", report.memory);
  const std::string error = decimal("%.4g", report.error);
  const Result<Reply> reply =
      client_.run(kUpdateTelemetry, {id_, incarnation_, report.owner, memory, error});
  if (!reply) return tl::unexpected(reply.error());
  if (reply->integer < 0) return std::nullopt;
  return static_cast<std::size_t>(reply->integer);
}

Result<void> WorkerDirectory::add_render_time(const std::map<std::string, std::uint64_t>& spent) {
  std::vector<std::string> arguments;
  for (const auto& [user, ms] : spent) {
    arguments.push_back(user);
    arguments.push_back(std::to_string(ms));
  }
  const Result<Reply> reply = client_.run(kAddRenderTime, views(arguments));
  if (!reply) return tl::unexpected(reply.error());
  return {};
}

Result<bool> WorkerDirectory::save_scene(const std::string& session_id, const SavedScene& saved) {
  std::vector<std::string> arguments{session_id};
  append(arguments, saved);
  const Result<Reply> reply = client_.run(kSaveScene, views(arguments));
  if (!reply) return tl::unexpected(reply.error());
  return reply->integer == 1;
}

Result<bool> WorkerDirectory::restore(const LostSession& session) {
  std::vector<std::string> arguments{session.id, session.user_id, session.data_set_id, id_,
                                     incarnation_};
  append(arguments, session.saved);
  arguments.emplace_back(session.visitor ? "1" : "");
  arguments.insert(arguments.end(), {session.over, session.to_first});
  arguments.insert(arguments.end(), session.links.begin(), session.links.end());
  const Result<Reply> reply = client_.run(kRebuildSession, views(arguments));
  if (!reply) return tl::unexpected(reply.error());
  return reply->integer == 1;
}

Result<std::vector<Peer>> WorkerDirectory::peers(const PeerQuery& query) {
  std::vector<std::string> arguments{id_,
                                     incarnation_,
                                     decimal("%.3f", query.asked),
                                     query.lent ? decimal("%.3f", *query.lent) : "",
                                     query.fleet,
                                     std::to_string(query.random)};
  arguments.insert(arguments.end(), query.helpers.begin(), query.helpers.end());
  const Result<Reply> reply = client_.run(kLend, views(arguments));
  if (!reply) return tl::unexpected(reply.error());
  std::vector<Peer> found;
  for (const Reply& one : reply->list) {
    Peer peer;
    peer.id = one.at(0);
    peer.address = one.at(1);
    peer.load = std::atof(one.at(2).c_str());
    peer.lent = std::atof(one.at(3).c_str());
    peer.age_s = std::atof(one.at(4).c_str()) / 1000;
    peer.draining = one.at(5) != "0";
    peer.volumes = split(one.at(6));
    peer.node = one.at(7);
    found.push_back(std::move(peer));
  }
  return found;
}

}  // namespace diaphane::directory
