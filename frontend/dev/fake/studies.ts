import { randomBytes, randomUUID } from "node:crypto";
import type { ServerResponse } from "node:http";
import type { JoinedStudy, StudyInfo } from "../../src/api/studies";
import { hasView, type Definition, type StudyLanguage } from "../../src/studies/definition";

interface FakeStudy {
  info: StudyInfo;
  definition: Definition;
  token: string;
  pictures: Map<string, Buffer>;
  participants: Map<string, { seed: number; language: StudyLanguage; answers: Map<string, unknown> }>;
}

const studies = new Map<string, FakeStudy>();
const byKey = (key: string) => [...studies.values()].find(({ participants }) => participants.has(key));

const shown = ({ info, definition, participants }: FakeStudy) => ({
  ...info,
  title: definition.title,
  places: definition.places,
  ends_at: definition.ends_at,
  joined: participants.size,
  definition,
  etag: '"1"',
});

type Say = (status: number, value?: unknown) => void;
interface Body {
  readonly definition: Definition;
  readonly state: StudyInfo["state"];
  readonly key: string;
  readonly token: string;
  readonly step: string;
  readonly value: unknown;
  readonly picture: string;
}

/** Answers the requests of a researcher: /v1/studies. */
export function answerResearcher(
  method: string,
  [id = "", more = "", name = ""]: readonly string[],
  raw: Buffer,
  say: Say,
  response: ServerResponse,
): void {
  const body = () => JSON.parse(raw.toString()) as Body;
  const study = studies.get(id);
  if (method === "GET" && id === "") say(200, { items: [...studies.values()].map(shown), next_cursor: null });
  else if (method === "POST" && id === "") {
    const definition = body().definition;
    const made = randomUUID();
    const info = { id: made, title: {}, state: "draft" as const, places: 0, joined: 0, finished: 0, withdrawn: 0 };
    const times = { ends_at: definition.ends_at, created_at: new Date().toISOString() };
    const one = { info: { ...info, ...times }, definition, token: "", pictures: new Map(), participants: new Map() };
    studies.set(made, one);
    say(201, shown(one));
  } else if (!study) say(404, { type: "urn:diaphane:problem:not-found", title: "Not found", status: 404 });
  else if (more === "") {
    if (method === "PUT") study.definition = body().definition;
    if (method === "DELETE") studies.delete(id);
    say(method === "DELETE" ? 204 : 200, method === "DELETE" ? undefined : shown(study));
  } else if (more === "state") {
    study.info = { ...study.info, state: body().state };
    say(200, shown(study));
  } else if (more === "link") {
    study.token = randomBytes(32).toString("hex");
    say(200, { path: `/study#${study.token}` });
  } else if (more === "preview") {
    say(200, join(study, body().key, "en"));
  } else if (more === "pictures") answerPicture(study, method, name, raw, say, response);
  else say(503, { type: "urn:diaphane:problem:unavailable", title: "Unavailable", status: 503 });
}

function answerPicture(
  study: FakeStudy,
  method: string,
  name: string,
  raw: Buffer,
  say: Say,
  response: ServerResponse,
): void {
  const picture = study.pictures.get(name);
  if (method === "PUT") {
    study.pictures.set(name, raw);
    say(204);
  } else if (picture) {
    response.writeHead(200, { "Content-Type": "image/jpeg" });
    response.end(picture);
  } else say(404, { type: "urn:diaphane:problem:not-found", title: "Not found", status: 404 });
}

function join(study: FakeStudy, key: string, language: StudyLanguage): JoinedStudy {
  const known = study.participants.get(key) ?? { seed: 7, language, answers: new Map<string, unknown>() };
  study.participants.set(key, known);
  const answered = [...known.answers.keys()];
  return { seed: known.seed, definition: study.definition, answered, sequence: answered.length };
}

/** Answers the requests of a participant: /v1/study. `visit` opens a session that begins with a scene. */
export function answerParticipant(
  what: string,
  raw: Buffer,
  say: Say,
  response: ServerResponse,
  visit: (scene: object) => object,
): void {
  const body = JSON.parse(raw.toString()) as Body;
  const { key } = body;
  const study = what === "invitation" || what === "participants" ? byToken(body.token) : byKey(key);
  if (what === "withdrawal") {
    study?.participants.delete(key);
    say(204);
  } else if (!study) say(404, { type: "urn:diaphane:problem:not-found", title: "Not found", status: 404 });
  else if (what === "invitation") say(200, invitation(study));
  else if (what === "participants") say(201, join(study, key, "en"));
  else if (what === "answers") {
    study.participants.get(key)?.answers.set(body.step, body.value);
    say(204);
  } else if (what === "pictures") answerPicture(study, "GET", body.picture, raw, say, response);
  else if (what === "visits") {
    const step = study.definition.steps.find(({ id }) => id === body.step);
    say(201, visit(step && hasView(step) && step.view ? step.view.scene : {}));
  } else say(204);
}

const byToken = (token: string) => [...studies.values()].find((one) => one.token === token);

const invitation = ({ definition, info, participants }: FakeStudy) => ({
  title: definition.title,
  languages: ["en", "de"],
  consent: definition.steps[0]?.text,
  record: definition.record,
  open: info.state === "open",
  places_left: definition.places - participants.size,
  steps: definition.steps.length,
  researcher: "Dr. Anna Example",
});
