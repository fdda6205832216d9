import { expect, it } from "vitest";
import { ApiProblem } from "../api/client";
import type { Definition, Step } from "./definition";
import { keepParticipant, keptParticipant, Participation, trialsKey } from "./participation";
import { newStep } from "./templates";

const key = "ab".repeat(32);
const step = (id: string): Step => ({ ...newStep("text", id), text: { en: id } });
const consent: Step = { id: "consent", kind: "consent", group: "", text: { en: "Yes" } };
const definition: Definition = {
  version: 1,
  template: "own",
  title: { en: "A study" },
  places: 5,
  ends_at: "2027-01-01T00:00:00Z",
  record: false,
  steps: [consent, step("a"), step("b"), step("c")],
};

function store() {
  const values = new Map<string, string>();
  return {
    getItem: (name: string) => values.get(name) ?? null,
    setItem: (name: string, value: string) => void values.set(name, value),
    removeItem: (name: string) => void values.delete(name),
  };
}

function begin(answered: readonly string[], here = store(), fail: ApiProblem | null = null) {
  const calls: string[] = [];
  const sequences: number[] = [];
  const call = (name: string) => (_key: string, what?: string) => {
    calls.push([name, what].filter(Boolean).join(" "));
    return fail ? Promise.reject(fail) : Promise.resolve();
  };
  const answer = (of: string, what: string, _value: unknown, _ms: number, sequence: number) => {
    sequences.push(sequence);
    return call("answer")(of, what);
  };
  const api = { answer, record: call("record"), finish: call("finish"), withdraw: call("withdraw") };
  const joined = { seed: 1, definition, answered, sequence: answered.length };
  const participation = new Participation(api, key, joined, false, here, () => () => undefined);
  return { participation, calls, sequences };
}

it("continues after the answers of the server, should the tab have lost its count", async () => {
  const { participation, sequences } = begin(["a", "b"]);
  participation.answer(step("c"), {}, 5);
  await participation.queue.whenEmpty();
  expect(sequences).toEqual([3]);
});

it("begins after the consent, at the first step without an answer", () => {
  const { participation } = begin(["a"]);
  expect(participation.steps.map(({ id }) => id)).toEqual(["a", "b", "c"]);
  expect(participation.current()?.id).toBe("b");
  expect(participation.answered()).toBe(1);
});

it("continues after a reload behind the answers that are not sent yet", () => {
  const here = store();
  const { participation } = begin([], here, new ApiProblem(0, "offline", ""));
  participation.answer(step("a"), {}, 10);
  participation.answer(step("b"), {}, 10);
  expect(begin([], here).participation.current()?.id).toBe("c");
});

it("finishes after the answers have arrived", async () => {
  const { participation, calls } = begin([]);
  for (const id of ["a", "b", "c"]) participation.answer(step(id), {}, 10);
  expect(participation.current()).toBeNull();
  await participation.finish();
  expect(calls).toEqual(["answer a", "answer b", "answer c", "finish"]);
});

it("does not finish a study that is closed", async () => {
  const { participation, calls } = begin([], store(), new ApiProblem(410, "gone", ""));
  participation.answer(step("a"), {}, 10);
  await participation.finish();
  expect(calls).toEqual(["answer a"]);
  expect(participation.queue.over.value).toBe("over");
});

it("forgets the answers of this tab after a withdrawal, and not before the server has", async () => {
  const here = store();
  const failed = begin([], here, new ApiProblem(503, "unavailable", ""));
  failed.participation.answer(step("a"), {}, 10);
  await expect(failed.participation.withdraw()).rejects.toThrow();
  expect(failed.participation.queue.pending.value).toHaveLength(1);
  const { participation, calls } = begin([], here);
  here.setItem(trialsKey(key, "b"), "[]");
  await participation.withdraw();
  expect(here.getItem(trialsKey(key, "b"))).toBeNull();
  expect(calls.at(-1)).toBe("withdraw");
  expect(begin([], here).participation.current()?.id).toBe("a");
});

it("remembers the participant of a link for this tab", () => {
  const here = store();
  const token = "cd".repeat(32);
  expect(keptParticipant(here, token)).toBeNull();
  keepParticipant(here, token, { key, record: true, ended: null });
  expect(keptParticipant(here, token)).toEqual({ key, record: true, ended: null });
  expect(keptParticipant(here, "ef".repeat(32))).toBeNull();
  here.setItem(`diaphane.study.${token.slice(0, 8)}`, '{"key":"short"}');
  expect(keptParticipant(here, token)).toBeNull();
});
