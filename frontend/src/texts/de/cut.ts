import type { Texts } from "../shape";

export const cut: Texts["cut"] = {
  title: "Diese Aufnahme anonymisieren",
  head: "Diese Aufnahme zeigt einen Kopf. Ein Gesicht kann man auf einer Aufnahme genauso erkennen wie auf einem Foto. Der schräge Schnitt entfernt das Gesicht. Drehen Sie das Bild und prüfen Sie, ob vom Gesicht nichts mehr zu sehen ist.",
  noHead:
    "Wir haben in dieser Aufnahme keinen Kopf gefunden, aber wir können uns irren. Sehen Sie sich das Bild von allen Seiten an. Ist ein Gesicht zu sehen oder etwas anderes, woran man jemanden erkennen kann?",
  noIdea:
    "Sehen Sie sich das Bild von allen Seiten an. Ist ein Gesicht zu sehen oder etwas anderes, woran man jemanden erkennen kann?",
  how: "Ziehen Sie an den runden Griffen im Bild, oder bewegen Sie die Regler. Alles, was Sie abschneiden, wird gelöscht.",
  area: "Quader im Bild",
  panel: "Was erhalten bleibt",
  facePlane: "Schräger Schnitt, um das Gesicht zu entfernen",
  plane: "Schräger Schnitt: Position",
  tilt: "Schräger Schnitt: Neigung",
  aside: "Schräger Schnitt: Drehung zur Seite",
  faces: {
    x: { low: "Rechte Seite", high: "Linke Seite" },
    y: { low: "Vorne", high: "Hinten" },
    z: { low: "Unten", high: "Oben" },
  },
  mm: (value) => `${value} mm`.replace("-", "−"),
  degrees: (value) => `${value}°`.replace("-", "−"),
  goes: (percent) =>
    percent === 0
      ? "Sie haben noch nichts weggeschnitten."
      : `${percent} % der Aufnahme ${percent === 1 ? "wird" : "werden"} gelöscht.`,
  keepAll: "Alles behalten",
  propose: "Vorgeschlagenen Schnitt verwenden",
  confirmCut: "Endgültig zuschneiden …",
  leave: "Abbrechen",
  confirmTitle: "Das lässt sich nicht rückgängig machen",
  confirmLead:
    "Was Sie wegschneiden, wird endgültig von unseren Festplatten gelöscht: aus der Aufnahme selbst, aus jedem Bild davon und für alle, die sie gerade ansehen. Niemand kann es wiederherstellen, weder Sie noch wir. Ihre CD zu Hause bleibt, wie sie ist.",
  confirmMarks:
    "Markierungen und Messungen, die mit dieser Aufnahme oder in Voreinstellungen gespeichert sind, werden gelöscht, weil in ihren Texten Namen stehen können.",
  confirmNothing:
    "Sie haben nichts weggeschnitten. Die ganze Aufnahme bleibt, wie sie ist, und nach der Bestätigung können Sie sie öffentlich machen.",
  confirmAfter:
    "Erst nach diesem Schritt können Sie die Aufnahme in die Galerie stellen. Von selbst kommt sie nicht dorthin. Alle, die hier ein Konto haben, sehen dann auch ihren Titel, ihre Beschreibung und die Namen ihrer Voreinstellungen.",
  understood:
    "Ich habe sie mir von allen Seiten angesehen, und mir ist klar, dass sich das nicht rückgängig machen lässt.",
  confirm: "Endgültig zuschneiden",
  working: "Die Aufnahme wird zugeschnitten. Das dauert ein paar Sekunden.",
  doneTitle: "Der Schnitt ist fertig",
  done: "Was Sie weggeschnitten haben, ist endgültig gelöscht.",
  donePrivate: "Die Aufnahme ist weiterhin privat.",
  doneShared:
    "Die Aufnahme ist nicht in der Galerie, aber alle, mit denen Sie sie geteilt haben oder die einen Link haben, können sie weiterhin öffnen.",
  look: "Aufnahme ansehen und teilen",
  failed: "Die Aufnahme konnte nicht zugeschnitten werden und ist unverändert. Versuchen Sie es noch einmal.",
  back: "Zurück zu meinen Aufnahmen",
};
