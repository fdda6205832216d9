-- Places a session on a worker and issues a ticket for it, in one round trip (docs/contracts.md, "Redis").
--
-- ARGV: session, user, data set, ticket, protocol epoch, reservation ms, ticket s, session s,
--       maximum placed sessions per user, maximum remembered sessions per user,
--       participant, name and hash of the link of a guest (empty for the owner);
--       first scene of a new session (a serialised Scene), or empty;
--       fleet to scale up if no slot is free, or empty;
--       browser session of the owner, or empty for guests and visitors;
--       relation of the viewer to the scan (SessionViewer), and whether the owner allows slices (1 or 0);
--       "1" for a viewer without an account; percentage of all slots that such viewers may hold together;
--       hash of the address of such a viewer: one address may hold at most half of that share;
--       whether the owner allows downloads (1 or 0);
--       account that the session is charged to, or empty for the user;
--       data set that a new session shows over its own, or empty, and its motion
-- Returns {"placed", worker, placement}, or {why}: "signed_out", "not_yours", "too_many", "no_worker", "full",
-- "no_memory", "visitors". If the session is not placed, writes nothing but that fact.

local session, user, data_set, ticket, epoch = ARGV[1], ARGV[2], ARGV[3], ARGV[4], ARGV[5]
local reservation_ms, ticket_s, session_s = tonumber(ARGV[6]), tonumber(ARGV[7]), tonumber(ARGV[8])
local most_placed, most_remembered = tonumber(ARGV[9]), tonumber(ARGV[10])
local by_visitor, visitor_percent, visitor_from = ARGV[19] == '1', tonumber(ARGV[20] or '0'), ARGV[21] or ''

-- A request that was authenticated just before its browser was signed out must not open a stream.
local browser = ARGV[16]
if browser ~= '' and redis.call('EXISTS', keys.browser_ended(browser)) == 1 then return {'signed_out'} end

local now = now_ms()
local session_key = keys.session(session)
-- A session that is charged to another account counts towards its limit.
local charged_to = ARGV[23] or ''
local user_key = keys.user_sessions(charged_to ~= '' and charged_to or user)
local data_set_key = keys.data_set_sessions(data_set)

-- Numbers for more than kSampledWorkers workers: `kLookers` of the newest sessions on the same data set, whose workers
-- are considered, and `kTries` random samples at most, until a worker has a free slot.
local kTries, kLookers = 8, 16
-- Added to the score of a worker on which a visitor would be displaced, so that such a worker is the last choice.
local kDisplaces = 1000

-- Returns whether a slot of `worker` is still reserved for `id`.
local function is_kept(worker, id)
  local expiry = redis.call('ZSCORE', keys.worker_sessions(worker), id)
  return expiry and tonumber(expiry) > now
end

-- Returns whether `worker` recently had no memory for this session.
local function has_refused(worker)
  local until_ms = redis.call('ZSCORE', keys.session_refused(session), worker)
  return until_ms and tonumber(until_ms) > now
end

local known = redis.call('HMGET', session_key, 'user', 'data_set', 'worker', 'incarnation', 'placement', 'visitor')
if known[1] and (known[1] ~= user or known[2] ~= data_set) then return {'not_yours'} end
local old_worker = known[3]

-- Returns the facts about a worker that this script needs, or nil if it accepts no sessions.
local function usable(worker)
  local w = redis.call('HMGET', keys.worker(worker),
                       'incarnation', 'epoch', 'draining', 'slots', 'load', 'volumes', 'expected', 'sessions', 'visitors')
  if not w[1] then
    redis.call('SREM', keys.workers, worker)
    return nil
  end
  if w[2] ~= epoch or w[3] == '1' then return nil end
  return {id = worker, incarnation = w[1], slots = tonumber(w[4]) or 0, load = tonumber(w[5]) or 0,
          volumes = ',' .. (w[6] or '') .. ',', expected = tonumber(w[7]), sessions = tonumber(w[8]) or 0,
          visitors = tonumber(w[9]) or 0}
end

-- Returns the expected load of a worker's device (docs/adr/0032). A session that started after the worker's last report
-- counts as one slot's share.
local function expected_of(w, used)
  if not w.expected then return math.max(w.load, used / w.slots) end
  return w.expected + math.max(0, used - w.sessions) / w.slots
end

local function better(a, b)
  if a.score ~= b.score then return a.score < b.score end
  if a.has_volume ~= b.has_volume then return a.has_volume end
  if a.share ~= b.share then return a.share < b.share end
  if a.load ~= b.load then return a.load < b.load end
  return a.id < b.id
end

local chosen, placement
local is_new = false  -- whether the session gets a new placement
if old_worker then
  local w = usable(old_worker)
  if w and w.incarnation == known[4] and is_kept(old_worker, session) and not has_refused(old_worker) then
    chosen, placement = w, tonumber(known[5])
  end
end

if not chosen then
  is_new = true
  -- Counts the user's other sessions and those that hold a slot, and finds the oldest without one.
  local placed, remembered, oldest_unplaced = 0, 0, nil
  for _, other in ipairs(redis.call('ZRANGE', user_key, 0, -1)) do
    if other ~= session then
      local worker = redis.call('HGET', keys.session(other), 'worker')
      if not worker then
        redis.call('ZREM', user_key, other)
      else
        remembered = remembered + 1
        if is_kept(worker, other) then
          placed = placed + 1
        else
          oldest_unplaced = oldest_unplaced or other
        end
      end
    end
  end
  if placed >= most_placed then return {'too_many'} end

  local why_not = 'no_worker'
  local considered = {}
  local workers_seen, slots_seen = 0, 0
  local function consider(worker)
    if considered[worker] then return end
    considered[worker] = true
    local w = usable(worker)
    if w then
      redis.call('ZREMRANGEBYSCORE', keys.worker_sessions(worker), '-inf', now)
      local used = redis.call('ZCARD', keys.worker_sessions(worker))
      if redis.call('ZSCORE', keys.worker_sessions(worker), session) then used = used - 1 end
      workers_seen, slots_seen = workers_seen + 1, slots_seen + w.slots
      -- A user with an account may displace a visitor. The worker does so when the new session arrives.
      local displaces = used >= w.slots and not by_visitor and used - w.visitors < w.slots
      if has_refused(worker) then
        why_not = 'no_memory'
      elseif used >= w.slots and not displaces then
        if why_not == 'no_worker' then why_not = 'full' end
      elseif by_visitor and w.visitors >= math.ceil(w.slots * visitor_percent / 100) then
        if why_not == 'no_worker' then why_not = 'visitors' end
      else
        w.share = used / w.slots
        w.has_volume = string.find(w.volumes, ',' .. data_set .. ',', 1, true) ~= nil
        w.score = expected_of(w, used) - (w.has_volume and kLoadedVolumeWorth or 0) + (displaces and kDisplaces or 0)
        if not chosen or better(w, chosen) then chosen = w end
      end
    end
  end
  local count = redis.call('SCARD', keys.workers)
  if count <= kSampledWorkers then
    for _, worker in ipairs(redis.call('SMEMBERS', keys.workers)) do consider(worker) end
  else
    -- A few random workers out of thousands balance the load almost as well as all of them, at a constant cost. The
    -- sessions on the data set tell which workers have its volume.
    for _, other in ipairs(redis.call('ZREVRANGE', data_set_key, 0, kLookers - 1)) do
      local worker = redis.call('HGET', keys.session(other), 'worker')
      if worker and redis.call('SISMEMBER', keys.workers, worker) == 1 then consider(worker) end
    end
    for _ = 1, kTries do
      for _, worker in ipairs(redis.call('SRANDMEMBER', keys.workers, kSampledWorkers)) do consider(worker) end
      if chosen then break end
    end
  end
  if by_visitor and chosen then
    -- common/visitor_share.h has the same rule. If only some workers were considered, the others are assumed to be similar.
    redis.call('ZREMRANGEBYSCORE', keys.visitors, '-inf', now)
    local visitors, from_there = 0, 0
    for _, other in ipairs(redis.call('ZRANGE', keys.visitors, 0, -1)) do
      if other ~= session then
        visitors = visitors + 1
        if redis.call('HGET', keys.session(other), 'visitor_from') == visitor_from then from_there = from_there + 1 end
      end
    end
    local slots = slots_seen * math.max(1, count / workers_seen)
    local share = 0
    if slots >= 2 and visitor_percent > 0 then share = math.max(1, math.floor(slots * visitor_percent / 100)) end
    local share_from_there = math.min(share, math.max(2, math.floor(share / 2)))
    if visitors >= share or from_there >= share_from_there then chosen, why_not = nil, 'visitors' end
  end
  -- A fleet does not grow when the visitors' share is used up. Otherwise, strangers could run up its costs.
  if not chosen and why_not == 'visitors' then return {why_not} end
  if not chosen then
    -- The operator makes room for sessions without a slot. Each session counts once, however often it asks.
    local refused_key = keys.refused(ARGV[15])
    redis.call('ZREMRANGEBYSCORE', refused_key, '-inf', now - kUnplacedMs)
    redis.call('ZADD', refused_key, now, session)
    redis.call('EXPIRE', refused_key, kUnplacedS)
    return {why_not}
  end

  if remembered >= most_remembered and oldest_unplaced then
    redis.call('DEL', keys.session(oldest_unplaced))
    redis.call('ZREM', user_key, oldest_unplaced)
  end
  if old_worker then redis.call('ZREM', keys.worker_sessions(old_worker), session) end
  placement = redis.call('HINCRBY', session_key, 'placement', 1)
  redis.call('HSETNX', session_key, 'opened', now)
  if not known[1] and ARGV[14] ~= '' then redis.call('HSET', session_key, 'scene', ARGV[14]) end
  if not known[1] and (ARGV[24] or '') ~= '' then redis.call('HSET', session_key, 'over', ARGV[24], 'to_first', ARGV[25]) end
  redis.call('DEL', keys.session_ended(session))
end

local until_ms = now + reservation_ms
local entry = redis.call('ZSCORE', keys.worker_sessions(chosen.id), session)
if not entry or tonumber(entry) < until_ms then
  redis.call('ZADD', keys.worker_sessions(chosen.id), until_ms, session)
end
redis.call('EXPIRE', keys.worker_sessions(chosen.id), kSlotsS)

-- Whether the slot counts as a visitor's. A new placement decides this, and a user with an account who joins a
-- visitor's session makes it count as theirs.
local visitor = known[6] == '1'
if not by_visitor then visitor = false elseif is_new then visitor = true end
if visitor then
  redis.call('ZADD', keys.visitors, until_ms, session)
  redis.call('EXPIRE', keys.visitors, kSlotsS)
else
  redis.call('ZREM', keys.visitors, session)
end
redis.call('HSET', session_key, 'user', user, 'data_set', data_set, 'worker', chosen.id,
           'incarnation', chosen.incarnation, 'reserved_until', until_ms, 'visitor', visitor and '1' or '')
if visitor and is_new then redis.call('HSET', session_key, 'visitor_from', visitor_from) end
if charged_to ~= '' then redis.call('HSET', session_key, 'charged_to', charged_to) end
-- Records all browsers that got a ticket. Signing out any of them ends the session.
if browser ~= '' then
  local browsers = redis.call('HGET', session_key, 'browsers') or ','
  if not string.find(browsers, ',' .. browser .. ',', 1, true) then
    redis.call('HSET', session_key, 'browsers', browsers .. browser .. ',')
  end
end
redis.call('EXPIRE', session_key, session_s)
local opened = redis.call('HGET', session_key, 'opened')
local indexes = {user_key, data_set_key}
local over = redis.call('HGET', session_key, 'over')
if over then indexes[3] = keys.data_set_sessions(over) end
for _, key in ipairs(indexes) do
  redis.call('ZADD', key, opened, session)
  redis.call('EXPIRE', key, session_s)
end

local ticket_key = keys.ticket(ticket)
redis.call('HSET', ticket_key, 'session', session, 'user', user, 'participant', ARGV[11], 'name', ARGV[12],
           'link', ARGV[13], 'viewer', ARGV[17], 'slices', ARGV[18], 'downloads', ARGV[22])
redis.call('EXPIRE', ticket_key, ticket_s)
return {'placed', chosen.id, tostring(placement)}
