-- Adds to what each person's pictures took of devices; `api` takes it from here into Postgres (docs/contracts.md, "Redis").
-- ARGV: user, milliseconds, ...
for i = 1, #ARGV, 2 do redis.call('HINCRBY', keys.render_time, ARGV[i], ARGV[i + 1]) end
return 1
