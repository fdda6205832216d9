#pragma once

#include <string_view>

namespace diaphane::directory {

/// A Lua file of scripts/, embedded at build time.
struct Script {
  std::string_view name;  ///< file name without .lua
  std::string_view source;
  std::string_view sha1;  ///< SHA-1 of the source in hexadecimal, for EVALSHA
};

// Defined in the generated scripts.cpp (embed_scripts.cmake).
extern const Script kAddRenderTime;
extern const Script kConsumeTicket;
extern const Script kDeregister;
extern const Script kEndLinks;
extern const Script kEndSessions;
extern const Script kEndedLinks;
extern const Script kFleets;
extern const Script kHeartbeat;
extern const Script kLend;
extern const Script kListSessions;
extern const Script kListWorkers;
extern const Script kMakeLink;
extern const Script kPlace;
extern const Script kRebuildSession;
extern const Script kSaveScene;
extern const Script kSessionRefused;
extern const Script kTakeRenderTime;
extern const Script kUpdateTelemetry;
extern const Script kWorkerLost;

}  // namespace diaphane::directory
