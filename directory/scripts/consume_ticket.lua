-- Consumes a ticket, even if it turns out to be unusable, and returns where its session is (docs/contracts.md, "Redis").
--
-- ARGV: ticket, reservation ms, session s
-- Returns {"attach", session, user, data set, worker, address, incarnation, placement, scene, input seq, width, height,
-- presenter, participant, name, link, viewer, slices, guest slices, visitor, downloads, over, to first}, or {why}: "unknown"
-- (ticket), "gone" (session), "worker_lost" (ask for a new ticket).

local ticket_key = keys.ticket(ARGV[1])
local ticket = redis.call('HMGET', ticket_key, 'session', 'user', 'participant', 'name', 'link', 'viewer',
                          'slices', 'downloads')
redis.call('DEL', ticket_key)
if not ticket[1] then return {'unknown'} end

local session = ticket[1]
local session_key = keys.session(session)
local s = redis.call('HMGET', session_key, 'user', 'data_set', 'worker', 'incarnation', 'placement', 'scene',
                     'input_seq', 'width', 'height', 'presenter', 'guest_slices', 'visitor', 'over', 'to_first')
if not s[1] or s[1] ~= ticket[2] then return {'gone'} end

local worker = s[3]
local w = redis.call('HMGET', keys.worker(worker), 'address', 'incarnation', 'slots', 'visitors')
-- The link may have been disabled after the ticket was issued.
if ticket[5] and ticket[5] ~= '' and redis.call('EXISTS', keys.link(ticket[5])) == 0 then return {'gone'} end
if not w[1] or w[2] ~= s[4] then return {'worker_lost'} end

-- A ticket outlives its reservation, so another session may hold the slot now.
local now = now_ms()
local entries = keys.worker_sessions(worker)
redis.call('ZREMRANGEBYSCORE', entries, '-inf', now)
local entry = redis.call('ZSCORE', entries, session)
-- A slot held by a visitor is free for a user with an account, who displaces the visitor (place.lua).
local displaced = s[12] == '1' and 0 or tonumber(w[4] or '0')
if not entry and redis.call('ZCARD', entries) - displaced >= tonumber(w[3]) then return {'worker_lost'} end
local until_ms = now + tonumber(ARGV[2])
if not entry or tonumber(entry) < until_ms then redis.call('ZADD', entries, until_ms, session) end
redis.call('EXPIRE', entries, kSlotsS)
if s[12] == '1' then
  redis.call('ZADD', keys.visitors, until_ms, session)
  redis.call('EXPIRE', keys.visitors, kSlotsS)
end
redis.call('HSET', session_key, 'reserved_until', until_ms)
redis.call('EXPIRE', session_key, tonumber(ARGV[3]))

return {'attach', session, s[1], s[2], worker, w[1], w[2], s[5] or '0', s[6] or '', s[7] or '0', s[8] or '0',
        s[9] or '0', s[10] or '', ticket[3] or '', ticket[4] or '', ticket[5] or '', ticket[6] or '', ticket[7] or '',
        s[11] or '', s[12] or '', ticket[8] or '', s[13] or '', s[14] or ''}
