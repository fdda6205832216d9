import { expect, test } from "vitest";
import { TaskQueue } from "./task_queue";

test("what a user waits for goes before preparations, one by one", async () => {
  const queue = new TaskQueue();
  const log: string[] = [];
  const task = (name: string) => async () => {
    log.push(`${name} begins`);
    await Promise.resolve();
    log.push(`${name} ends`);
  };
  await Promise.all([
    queue.addPreparation(task("first")),
    queue.addPreparation(task("second")),
    queue.add(task("shown")),
  ]);
  const order = ["first", "shown", "second"];
  expect(log).toEqual(order.flatMap((name) => [`${name} begins`, `${name} ends`]));
});

test("a task that fails does not stop those after it", async () => {
  const queue = new TaskQueue();
  const failed = queue.add(() => Promise.reject(new Error("lost")));
  const next = queue.add(() => Promise.resolve(2));
  await expect(failed).rejects.toThrow("lost");
  expect(await next).toBe(2);
  expect(await queue.add(() => Promise.resolve(3))).toBe(3);
});
