import type { Definition, Step, Template, Text } from "./definition";

type Texts = typeof import("../texts/en/study_templates").studyTemplates;
type German = typeof import("../texts/de/study_templates").studyTemplates;

const days = 86_400_000;
/** The places and the duration of a new study. The participants of the thesis were 43. */
const firstPlaces = 43;
const firstDays = 30;
const validationPictures = [-2, -1, 0, 1, 2];
const latencyDelays = [0, 50, 100, 150, 200, 300, 400];

/** Returns a definition to start with. Its texts are in both languages, and its views are still to be chosen. */
export async function newDefinition(template: Template, nowMs: number): Promise<Definition> {
  const [{ studyTemplates: en }, { studyTemplates: de }] = await Promise.all([
    import("../texts/en/study_templates"),
    import("../texts/de/study_templates"),
  ]);
  return {
    version: 1,
    template,
    title: { en: en.titles[template], de: de.titles[template] },
    places: firstPlaces,
    ends_at: new Date(nowMs + firstDays * days).toISOString(),
    record: false,
    steps: [plain("consent", "consent", { en: en.consent, de: de.consent }), ...stepsOf(template, en, de)],
  };
}

const plain = (kind: "consent" | "text" | "words", id: string, text: Text): Step => ({ id, kind, group: "", text });

function stepsOf(template: Template, en: Texts, de: German): Step[] {
  const both = (pick: (texts: Texts | German) => string): Text => ({ en: pick(en), de: pick(de) });
  const remarks = plain(
    "words",
    "remarks",
    both((texts) => texts.remarks),
  );
  switch (template) {
    case "comfort":
      return [...comfort(both), remarks];
    case "validation":
      return [
        {
          id: "order",
          kind: "order",
          group: "",
          text: both((texts) => texts.order),
          pictures: validationPictures.map((comfort, i) => ({ id: `picture-${i + 1}`, comfort })),
        },
        remarks,
      ];
    case "viewpoints":
      return [{ id: "viewpoint", kind: "viewpoint", group: "", text: both((texts) => texts.viewpoint) }, remarks];
    case "latency":
      return [
        { id: "latency", kind: "latency", group: "", text: both((texts) => texts.latency), delays_ms: latencyDelays },
        remarks,
      ];
    case "sus":
      return sus(en, de, both);
    case "own":
      return [
        plain(
          "text",
          "instructions",
          both((texts) => texts.instructions),
        ),
      ];
  }
}

type Both = (pick: (texts: Texts | German) => string) => Text;

function comfort(both: Both): Step[] {
  return [
    {
      id: "rating",
      kind: "rating",
      group: "",
      text: both((texts) => texts.rating),
      low: 0,
      high: 10,
      low_text: both((texts) => texts.ratingLow),
      high_text: both((texts) => texts.ratingHigh),
    },
    { id: "colours", kind: "colours", group: "", text: both((texts) => texts.colours), materials: [] },
  ];
}

function sus(en: Texts, de: German, both: Both): Step[] {
  return en.sus.map((text, i) => ({
    id: `sus-${i + 1}`,
    kind: "rating" as const,
    group: "",
    text: { en: text, de: de.sus[i] ?? "" },
    low: 1,
    high: 5,
    low_text: both((texts) => texts.susLow),
    high_text: both((texts) => texts.susHigh),
  }));
}

/** Returns a new step of a kind with empty texts. */
export function newStep(kind: Step["kind"], id: string): Step {
  const base = { id, group: "", text: {} };
  switch (kind) {
    case "rating":
      return { ...base, kind, low: 0, high: 10, low_text: {}, high_text: {} };
    case "colours":
      return { ...base, kind, materials: [] };
    case "order":
      return { ...base, kind, pictures: validationPictures.map((comfort, i) => ({ id: `${id}-${i + 1}`, comfort })) };
    case "viewpoint":
      return { ...base, kind };
    case "choice":
      return {
        ...base,
        kind,
        multiple: false,
        options: [
          { id: "option-1", text: {} },
          { id: "option-2", text: {} },
        ],
      };
    case "latency":
      return { ...base, kind, delays_ms: latencyDelays };
    default:
      return { ...base, kind };
  }
}
