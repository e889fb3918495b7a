"use strict";
(function () {
  var root = document.documentElement;
  root.classList.remove("no-script");
  document.getElementById("theme").addEventListener("click", function () {
    var dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = dark ? "light" : "dark";
  });
  var data = JSON.parse(document.getElementById("frames").textContent);
  var times = data.times, slider = document.getElementById("time"), play = document.getElementById("play");
  var lines = document.querySelectorAll("#drawing line"), dots = document.querySelectorAll("#drawing circle");
  var held = document.querySelectorAll("#drawing [data-connector]"), cursors = document.querySelectorAll(".cursor");
  var first = times[0], length = times[times.length - 1] - first || 1;
  var began = null;
  function show(frame) {
    var points = data.points[frame], sticks = data.sticks[frame];
    lines.forEach(function (line) {
      var a = 2 * line.dataset.a, b = 2 * line.dataset.b;
      line.setAttribute("x1", points[a]); line.setAttribute("y1", points[a + 1]);
      line.setAttribute("x2", points[b]); line.setAttribute("y2", points[b + 1]);
    });
    dots.forEach(function (dot) {
      var p = 2 * dot.dataset.p;
      dot.setAttribute("cx", points[p]); dot.setAttribute("cy", points[p + 1]);
    });
    held.forEach(function (link) { link.classList.toggle("sticks", sticks.indexOf(+link.dataset.connector) >= 0); });
    var shift = (times[frame] - first) / length * (data.across[1] - data.across[0]);
    cursors.forEach(function (cursor) { cursor.setAttribute("transform", "translate(" + shift + " 0)"); });
    root.classList.add("playing");
    slider.value = frame;
    document.getElementById("now").textContent = "t = " + times[frame].toPrecision(6);
  }
  function at(time) {
    var low = 0, high = times.length - 1;
    while (low < high) {
      var middle = (low + high + 1) >> 1;
      if (times[middle] <= time) { low = middle; } else { high = middle - 1; }
    }
    return low;
  }
  function step(now) {
    if (began === null) { return; }
    // The motion takes its own time, within 4 to 12 seconds.
    var part = (now - began) / (1000 * Math.min(12, Math.max(4, length)));
    show(at(first + Math.min(1, part) * length));
    if (part < 1) { requestAnimationFrame(step); } else { stop(); }
  }
  function stop() { began = null; play.textContent = "play"; }
  play.addEventListener("click", function () {
    if (began !== null) { stop(); return; }
    began = performance.now();
    play.textContent = "stop";
    requestAnimationFrame(step);
  });
  slider.addEventListener("input", function () { stop(); show(+slider.value); });
  document.addEventListener("keydown", function (event) {
    if (event.key === " " && event.target === document.body) { event.preventDefault(); play.click(); }
  });
  var asked = /^#t=([-+.0-9eE]+)$/.exec(location.hash);
  show(asked ? at(+asked[1]) : 0);
}());
