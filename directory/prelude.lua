-- Precedes every script of scripts/, after the constants of constants.h (embed_scripts.cmake).
-- Keys of workers are not known beforehand, so no script declares its keys: this requires one Redis, not a Redis Cluster.

-- The keys of docs/contracts.md, "Redis".
local keys = {
  workers = 'diaphane:workers',
  visitors = 'diaphane:visitors',
  render_time = 'diaphane:render_time',
}
function keys.worker(id) return 'diaphane:worker:' .. id end
function keys.worker_sessions(id) return 'diaphane:worker:' .. id .. ':sessions' end
function keys.worker_drain(id) return 'diaphane:worker:' .. id .. ':drain' end
function keys.session(id) return 'diaphane:session:' .. id end
function keys.session_ended(id) return 'diaphane:session:' .. id .. ':ended' end
function keys.session_links(id) return 'diaphane:session:' .. id .. ':links' end
function keys.session_refused(id) return 'diaphane:session:' .. id .. ':refused' end
-- The sessions of a person ("user") or of a data set ("data_set").
function keys.sessions_of(what, id) return 'diaphane:' .. what .. ':' .. id .. ':sessions' end
function keys.user_sessions(id) return keys.sessions_of('user', id) end
function keys.data_set_sessions(id) return keys.sessions_of('data_set', id) end
function keys.browser_ended(id) return 'diaphane:browser:' .. id .. ':ended' end
function keys.ticket(ticket) return 'diaphane:ticket:' .. ticket end
function keys.link(hash) return 'diaphane:link:' .. hash end
function keys.link_ended(hash) return 'diaphane:link:' .. hash .. ':ended' end
function keys.fleet_last_used(fleet) return 'diaphane:fleet:' .. fleet .. ':last_used' end
-- All api processes without a fleet share one set.
function keys.refused(fleet) return fleet == '' and 'diaphane:refused' or 'diaphane:fleet:' .. fleet .. ':refused' end

-- Returns the time of the Redis server in ms, so that the clocks of other machines do not matter.
local function now_ms()
  local time = redis.call('TIME')
  return tonumber(time[1]) * 1000 + math.floor(tonumber(time[2]) / 1000)
end

