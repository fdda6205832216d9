-- Returns which of these links were disabled on purpose. ARGV: hashes of their tokens.
local ended = {}
for _, hash in ipairs(ARGV) do
  if redis.call('EXISTS', keys.link_ended(hash)) == 1 then ended[#ended + 1] = hash end
end
return ended
