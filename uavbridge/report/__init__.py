"""What a mission came to: results as arrays, summary.json, report.html, a screen of text."""
