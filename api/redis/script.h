#pragma once

#include <string_view>

namespace diaphane::api::redis {

/// A Lua file of this folder, embedded when it was built.
struct Script {
  std::string_view name;  ///< file name without .lua
  std::string_view source;
  std::string_view sha1;  ///< of the source, in hexadecimal: EVALSHA's name for it
};

// Defined in the generated scripts.cpp (embed_scripts.cmake).
extern const Script kPlace;
extern const Script kConsumeTicket;
extern const Script kListSessions;
extern const Script kEndSessions;
extern const Script kListWorkers;
extern const Script kWorkerLost;
extern const Script kSessionRefused;
extern const Script kMakeLink;
extern const Script kEndLinks;
extern const Script kEndedLinks;
extern const Script kTakeRenderTime;

}  // namespace diaphane::api::redis
